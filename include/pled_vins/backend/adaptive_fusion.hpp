#pragma once

#include "pled_vins/backend/fusion_config.hpp"

/// The paper's way (FusionMode::kPaper) to join what time tells of a feature with what geometry
/// tells. All weights in [0, 1], 1 at rest. z of NaN is no evidence, and no evidence is no fusion:
/// the weight of geometry stays. Ours; the paper's z is 1 there and would speak for rest.
/// Cost: some ns; no allocation.
namespace pled {

/// (1 - a) w_ba + a z with a = alpha0 exp(-|z - w_ba| / tau): eqs. (12) and (14). Moves the weight
/// by alpha0 tau / e at most, where the two differ by tau; where they differ more they are left
/// apart.
/// @param w_ba    the weight of geometry, robust_weight()
/// @param z       the temporal weight; NaN: unknown
/// @param config  in its ranges, see check()
[[nodiscard]] double paper_point_fusion(double w_ba, double z, const FusionConfig& config) noexcept;

/// (1 - a) w_ba + a z: eq. (13).
/// @param alpha_line  a of eq. (15), 0 ... 1, LineMeasurement::alpha_line; NaN: unknown, as of z
[[nodiscard]] double paper_line_fusion(double w_ba, double z, double alpha_line) noexcept;

}  // namespace pled
