#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "pled_vins/config/app_config.hpp"

namespace pled::apps {

/// How a feature's weight is found.
enum class WeightMethod : std::uint8_t {
  kNone,     ///< every weight is 1: the robust loss of each sighting alone
  kDefault,  ///< as the settings say
  kPaper,    ///< the paper's loss with its lambdas for VIODE, its temporal score, its fusion
  /// DynaVINS' loss with its lambdas for VIODE; as it knows no temporal weight, the paper's fusion
  kDynavins,
};

/// One configuration of the paper's ablation.
struct Ablation {
  WeightMethod method = WeightMethod::kDefault;
  bool temporal = true;  ///< false: geometry alone
  bool lines = true;     ///< false: points alone
};

/// All that `ablate` runs, in its order.
inline constexpr std::array kAblations{
    Ablation{WeightMethod::kNone, false, false},     Ablation{WeightMethod::kNone, false, true},
    Ablation{WeightMethod::kDefault, false, false},  Ablation{WeightMethod::kDefault, false, true},
    Ablation{WeightMethod::kDefault, true, false},   Ablation{WeightMethod::kDefault, true, true},
    Ablation{WeightMethod::kPaper, false, false},    Ablation{WeightMethod::kPaper, false, true},
    Ablation{WeightMethod::kPaper, true, false},     Ablation{WeightMethod::kPaper, true, true},
    Ablation{WeightMethod::kDynavins, false, false}, Ablation{WeightMethod::kDynavins, false, true},
    Ablation{WeightMethod::kDynavins, true, false},  Ablation{WeightMethod::kDynavins, true, true},
};

/// none, default, paper or dynavins
[[nodiscard]] std::string_view method_name(const Ablation& ablation) noexcept;
/// What weights come from: none, geometric or geometric+temporal
[[nodiscard]] std::string_view evidence_name(const Ablation& ablation) noexcept;
/// points or points+lines
[[nodiscard]] std::string_view features_name(const Ablation& ablation) noexcept;

/// The settings of a configuration: those given, but for what it is about. With lines they are
/// looked for where the settings say, or where they are by default if that is nowhere; the default
/// method with time fuses as the settings say, by default if they say not at all.
[[nodiscard]] AppConfig ablated(AppConfig config, const Ablation& ablation);

}  // namespace pled::apps
