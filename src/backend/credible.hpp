#pragma once

#include <Eigen/Geometry>

#include "pled_vins/imu/preintegration.hpp"

namespace pled {

/// False when the mean force or turning rate over an interval is nothing that a body carrying a
/// camera does: what came in was not a measurement.
[[nodiscard]] inline bool credible(const Preintegration& step, const NavState& from) noexcept {
  constexpr double kMostForce_mps2 = 80.0;
  constexpr double kMostTurn_radps = 40.0;
  const double dt_s = step.dt_s();
  return step.delta_v(from.bg, from.ba).norm() < kMostForce_mps2 * dt_s &&
         Eigen::AngleAxisd(step.delta_q(from.bg)).angle() < kMostTurn_radps * dt_s;
}

}  // namespace pled
