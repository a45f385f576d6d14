#pragma once

#include <Eigen/Core>

#include "pled_vins/backend/window.hpp"

namespace pled {

/// Poses that one sighting depends on.
struct PointFrames {
  Pose T_world_body_i;  ///< anchor
  Pose T_body_cam_i;
  Pose T_world_body_j;  ///< observer
  Pose T_body_cam_j;
};

/// d(residual) by the tangents (p, theta with R Exp(theta)) of what it depends on, and by the
/// point: bearing x, y and inverse depth.
struct PointJacobians {
  Eigen::Matrix<double, 2, 6> pose_i, pose_j, extrinsic_i, extrinsic_j;
  Eigen::Matrix<double, 2, 3> point;
  Eigen::Vector2d time_shift;
  bool with_extrinsic = true;  ///< set by the caller; false: those two come out 0, cheaper
};

/// Reprojection residual of a point in inverse depth, in sigmas:
///   r = (f / sigma_px) [ c.xy / c.z - xy_j ],
///   c = R_cj_ci (x, y, 1) + rho t_cj_ci, the point in camera j scaled by rho.
/// The scaled form is finite for points at infinity. Behind the camera c.z is held at a
/// small value: a large residual, which the robust loss sets aside.
///
/// @param point            x, y, rho of the point in camera i.
/// @param time_shift_s     state time = measurement time + shift; bearings move by -rate * shift.
/// @param sigmas_per_unit  f / sigma_px.
/// @param jacobians        null: skipped.
/// @returns false, with all outputs set all the same, when the point is behind camera j.
bool point_residual(const PointFrames& frames, const std::array<double, 3>& point,
                    const Observation& seen, double time_shift_s, double sigmas_per_unit,
                    Eigen::Vector2d& residual, PointJacobians* jacobians) noexcept;

/// The anchor's own sighting: r = (f / sigma_px) [ (x, y) - xy_i ]; poses play no part.
void anchor_residual(const std::array<double, 3>& point, const Observation& seen,
                     double time_shift_s, double sigmas_per_unit, Eigen::Vector2d& residual,
                     PointJacobians* jacobians) noexcept;

}  // namespace pled
