#pragma once

#include <optional>
#include <string>

#include "pled_vins/config/app_config.hpp"

namespace pled::apps {

/// The settings of a file, or the built-in ones when `file` is empty; absent, with words
/// on stderr, when it cannot be used.
[[nodiscard]] std::optional<AppConfig> settings(const std::string& file);

/// The same; when `file` is empty, those of the recording's own settings.yaml, if it has one, with
/// a note that they are used.
[[nodiscard]] std::optional<AppConfig> settings_for(const std::string& recording,
                                                    const std::string& file);

}  // namespace pled::apps
