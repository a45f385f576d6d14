#pragma once

#include <cstdint>

#include "pled_vins/core/config_issue.hpp"

namespace pled {

/// How what time tells (z) and what geometry tells become one weight.
enum class FusionMode : std::uint8_t {
  kNone,   ///< geometry alone
  kPaper,  ///< eq. (12) to (17), once a frame, after its solve
  /// Ours: z is one more quadratic term of the loss, lambda_z (w - z)^2. It speaks most where
  /// geometry says little; nothing has to agree first, and the weight stays a minimiser.
  kPrior,
};

/// Tuning of the fusion of temporal and geometric reliability.
struct FusionConfig {
  FusionMode mode = FusionMode::kPrior;
  double alpha0 = 0.4;     ///< kPaper: base rate for points, 0 ... 1. Paper, section IV-A
  double tau = 0.2;        ///< kPaper: decay with disagreement, 0.01 ... 10. Paper, section IV-A
  double lambda_z = 16.0;  ///< kPrior: per observation, in the units of lambda_w, 0 ... 1000
};

[[nodiscard]] constexpr ConfigIssue check(const FusionConfig& c) noexcept {
  if (!(c.alpha0 >= 0 && c.alpha0 <= 1)) return {"fusion.alpha0", "must be in [0, 1]"};
  if (!(c.tau >= 0.01 && c.tau <= 10)) return {"fusion.tau", "must be in [0.01, 10]"};
  if (!(c.lambda_z >= 0 && c.lambda_z <= 1000)) return {"fusion.lambda_z", "must be in [0, 1000]"};
  return {};
}
static_assert(check(FusionConfig{}).key == nullptr, "defaults must be valid");

}  // namespace pled
