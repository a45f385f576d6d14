#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "pled_vins/geometry/pose.hpp"

namespace pled::cue {

/// Ends at a smaller angle are no line, and one whose plane is as near to z = 1 has no picture.
inline constexpr double kLeastNormal = 1e-6;

/// One earlier sight of a line. As seen from there the moment of the line through p_1 / rho_1 and
/// p_2 / rho_2, p the ends seen now, is, up to a factor,
///   m = n + rho_1 by_rho[0] + rho_2 by_rho[1],
/// and an end q lies |q . m| / |m_xy| off its picture.
struct LineSight {
  Eigen::Vector3d n;
  std::array<Eigen::Vector3d, 2> by_rho;
  std::array<Eigen::Vector3d, 2> ends;  ///< (x, y, 1), seen then
};

/// @param now, then  the ends, those now kLeastNormal or more apart
[[nodiscard]] LineSight sight_of(const Pose& T_then_now, const std::array<Eigen::Vector3d, 2>& now,
                                 const std::array<Eigen::Vector2d, 2>& then) noexcept;

struct DepthsFit {
  Eigen::Vector2d rho = Eigen::Vector2d::Zero();  ///< inverse depths of the ends
  double squares = 0.0;                           ///< left over, bearing units
  double sigma = 0.0;        ///< of the middle's rho, for ends with unit noise in bearing units
  double free_depths = 0.0;  ///< how many of the two could have explained more than noise
};

/// The inverse depths in [0, kMaxInverseDepth] that bring the line closest to the ends: two linear
/// steps, then at most kFitSteps of Gauss-Newton, each solved exactly within these bounds.
/// @param noise  of an end across its line, bearing units
[[nodiscard]] DepthsFit best_depths(std::span<const LineSight> sights, double noise) noexcept;

}  // namespace pled::cue
