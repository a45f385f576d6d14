#include "src/apps/settings.hpp"

#include <filesystem>
#include <system_error>
#include <variant>

#include "src/apps/text.hpp"

namespace pled::apps {

std::optional<AppConfig> settings(const std::string& file) {
  if (file.empty()) return AppConfig{};
  auto loaded = load_config(file);
  if (const auto* error = std::get_if<ConfigError>(&loaded)) {
    print_error(error->message());
    return std::nullopt;
  }
  return std::get<AppConfig>(std::move(loaded));
}

std::optional<AppConfig> settings_for(const std::string& recording, const std::string& file) {
  const std::filesystem::path own = std::filesystem::path(recording) / "settings.yaml";
  std::error_code ignored;
  if (!file.empty() || !std::filesystem::is_regular_file(own, ignored)) return settings(file);
  print_note("settings are those of " + own.string() + "; --config names others");
  return settings(own.string());
}

}  // namespace pled::apps
