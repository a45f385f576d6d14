#include "src/apps/settings.hpp"

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

}  // namespace pled::apps
