#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "pled_vins/geometry/line.hpp"
#include "pled_vins/geometry/pose.hpp"

namespace pled {

/// One sighting of a line from a state of the window. The ends are where this frame saw it end,
/// not the same places of the line in every frame.
struct LineObservation {
  std::uint8_t state = 0;                 ///< index into the window
  std::uint8_t camera = 0;                ///< index into the rig
  std::array<double, 2> start_xy{};       ///< on the plane z = 1
  std::array<double, 2> end_xy{};         ///< in either order
  std::array<double, 2> start_rate_ps{};  ///< its rate, 1/s; only what crosses the line counts
  std::array<double, 2> end_rate_ps{};
};

/// Where a line is seen from.
struct LineFrames {
  Pose T_world_body;
  Pose T_body_cam;
  /// The line's own origin, fixed for its life; its axes are the world's. Where a camera saw the
  /// line: through that place it does not run, so its four numbers stay regular (see
  /// OrthonormalLine). The world's origin has no such promise.
  Eigen::Vector3d origin_world = Eigen::Vector3d::Zero();
};

/// d(residual) by the tangents (p, theta with R Exp(theta)) of what it depends on, and by the
/// line's step.
struct LineJacobians {
  Eigen::Matrix<double, 2, 6> pose, extrinsic;
  Eigen::Matrix<double, 2, 4> line;
  Eigen::Vector2d time_shift;
  bool with_extrinsic = true;  ///< set by the caller; false: that one comes out 0, cheaper
};

/// Reprojection residual of a line, eq. (11), in sigmas: the signed distances of the ends seen to
/// the line's picture,
///   r = (f / sigma_px) [ u_s . l, u_e . l ] / sqrt(l_1^2 + l_2^2),
///   l = n_c, the line's moment about the camera on the plane z = 1.
/// Motion along the line changes nothing: its ends are no points of it.
///
/// @param time_shift_s     state time = measurement time + shift; ends move by -rate * shift.
/// @param sigmas_per_unit  f / sigma_px, > 0; sigma of an end across the line.
/// @param jacobians        null: skipped.
/// @returns false when the line has no picture within 50 of the optical axis on the plane z = 1
///          (it passes through the camera, or nearly so), or a value is not finite. The residual is
///          then 50 f / sigma_px, which the robust loss sets aside, and all Jacobians are 0.
bool line_residual(const LineFrames& frames, const OrthonormalLine& line,
                   const LineObservation& seen, double time_shift_s, double sigmas_per_unit,
                   Eigen::Vector2d& residual, LineJacobians* jacobians) noexcept;

}  // namespace pled
