#pragma once

#include <span>

#include <Eigen/Core>

#include "pled_vins/frontend/motion_check.hpp"

namespace pled {

/// What fits pairs of bearings best: a translation's direction and what the gyro's rotation lacks.
struct EpipolarFit {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< as MotionEstimate's, unit
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();    ///< R_to_from_true = exp(turn) R_to_from
};

/// Refines the direction that the two-point check found, together with the small rotation that a
/// gyro with unknown bias has missed, over all pairs: Gauss-Newton on the distances to the epipolar
/// lines, b . (t x R a) over the line's normal, with Cauchy weights so that what moves by itself
/// does not count much. Ours.
/// @param turn_sigma_rad  what to expect of the missed rotation, one axis
/// Cost: about 100 instructions a pair and step, kSteps steps.
[[nodiscard]] EpipolarFit fit_epipolar(const Eigen::Matrix3d& R_to_from,
                                       std::span<const BearingPair> pairs,
                                       const Eigen::Vector3d& direction, double focal_px,
                                       double turn_sigma_rad) noexcept;

}  // namespace pled
