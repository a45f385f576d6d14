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
using ConfigField = std::variant<double*, int*, bool*, std::string*, TemporalScore*, EventPicture*,
                                 LineSource*, RobustMode*, FusionMode*>;

/// How a settings file and the command line call them.
inline constexpr std::array kTemporalScoreNames{
    std::pair{TemporalScore::kMotion, std::string_view("motion")},
    std::pair{TemporalScore::kPaper, std::string_view("paper")},
    std::pair{TemporalScore::kCount, std::string_view("count")},
};

inline constexpr std::array kEventPictureNames{
    std::pair{EventPicture::kBrightness, std::string_view("brightness")},
    std::pair{EventPicture::kTimeSurface, std::string_view("time_surface")},
};

inline constexpr std::array kLineSourceNames{
    std::pair{LineSource::kNone, std::string_view("none")},
    std::pair{LineSource::kEvents, std::string_view("events")},
    std::pair{LineSource::kFrames, std::string_view("frames")},
    std::pair{LineSource::kBoth, std::string_view("both")},
};

inline constexpr std::array kRobustModeNames{
    std::pair{RobustMode::kNone, std::string_view("none")},
    std::pair{RobustMode::kPerObservation, std::string_view("per_observation")},
    std::pair{RobustMode::kPaper, std::string_view("paper")},
    std::pair{RobustMode::kDynavins, std::string_view("dynavins")},
};

inline constexpr std::array kFusionModeNames{
    std::pair{FusionMode::kNone, std::string_view("none")},
    std::pair{FusionMode::kPaper, std::string_view("paper")},
    std::pair{FusionMode::kPrior, std::string_view("prior")},
};

/// The names of an enumeration that a setting may have.
[[nodiscard]] constexpr const auto& names_of(TemporalScore /*kind*/) noexcept {
  return kTemporalScoreNames;
}
[[nodiscard]] constexpr const auto& names_of(EventPicture /*kind*/) noexcept {
  return kEventPictureNames;
}
[[nodiscard]] constexpr const auto& names_of(LineSource /*kind*/) noexcept {
  return kLineSourceNames;
}
[[nodiscard]] constexpr const auto& names_of(RobustMode /*kind*/) noexcept {
  return kRobustModeNames;
}
[[nodiscard]] constexpr const auto& names_of(FusionMode /*kind*/) noexcept {
  return kFusionModeNames;
}

template <typename Enum>
[[nodiscard]] constexpr std::string_view name_of(Enum value) noexcept {
  for (const auto& [known, name] : names_of(value))
    if (known == value) return name;
  return {};
}

/// "motion, paper or count"
template <typename Enum>
[[nodiscard]] std::string choices() {
  std::string out;
  std::size_t left = names_of(Enum{}).size();
  for (const auto& [value, name] : names_of(Enum{})) {
    out += name;
    --left;
    out += left > 1 ? ", " : (left == 1 ? " or " : "");
  }
  return out;
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
