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
  std::error_code ignored;
  const std::filesystem::path path(recording);
  // Of a recording that is one file they lie beside it.
  const bool is_file = std::filesystem::is_regular_file(path, ignored);
  const std::filesystem::path own = (is_file ? path.parent_path() : path) / "settings.yaml";
  if (!file.empty() || !std::filesystem::is_regular_file(own, ignored)) return settings(file);
  print_note("settings are those of " + own.string() + "; --config names others");
  return settings(own.string());
}

}  // namespace pled::apps
