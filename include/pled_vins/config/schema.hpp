#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "pled_vins/config/app_config.hpp"

namespace pled {

/// Where one setting lives; the alternative is its type.
using ConfigField = std::variant<double*, int*, bool*, std::string*, TemporalScore*>;

/// How a settings file and the command line call them.
inline constexpr std::array kTemporalScoreNames{
    std::pair{TemporalScore::kMotion, std::string_view("motion")},
    std::pair{TemporalScore::kPaper, std::string_view("paper")},
    std::pair{TemporalScore::kCount, std::string_view("count")},
};

[[nodiscard]] constexpr std::string_view name_of(TemporalScore score) noexcept {
  for (const auto& [known, name] : kTemporalScoreNames)
    if (known == score) return name;
  return {};
}

/// One setting that a file may hold. Type and default follow from `field`.
struct ConfigKey {
  std::string_view key;   ///< `section.name`, or a bare name at the top of the file
  std::string_view unit;  ///< empty when it has none
  double low = 0.0;       ///< inclusive; numbers only
  double high = 0.0;      ///< inclusive; numbers only
  std::string_view doc;   ///< one line
  ConfigField (*field)(AppConfig& config) = nullptr;
};

/// Every setting, in the order of the documented file. The one place that knows a
/// key: reading, range checks and the documented defaults follow from it.
[[nodiscard]] std::span<const ConfigKey> config_schema() noexcept;

}  // namespace pled
