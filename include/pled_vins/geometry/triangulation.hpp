#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "pled_vins/geometry/pose.hpp"

namespace pled {

inline constexpr std::size_t kMaxTriangulationViews = 32;

/// Rays closer to parallel than this (rad) say nothing about depth: 0.02 px at f = 200 px.
inline constexpr double kMinTriangulationParallax_rad = 1e-4;

/// A point seen by one camera.
struct BearingView {
  Pose T_world_cam;
  Eigen::Vector2d bearing_xy = Eigen::Vector2d::Zero();  ///< undistorted, on the plane z = 1
};

struct TriangulatedPoint {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< m
  double inverse_depth = 0.0;                         ///< 1 / z in the anchor's camera frame, 1/m
  double parallax_rad = 0.0;  ///< largest angle at the point between two of the cameras
  double rms_error = 0.0;     ///< root mean square distance to the bearings, plane z = 1
};

/// The point that views[0..n) see, by least squares of the distances on the plane z = 1.
///
/// First the point nearest to all rays, then at most 8 Gauss-Newton steps in the anchor's bearing
/// and inverse depth, in which far points stay well conditioned.
///
/// @param[in] views   2 to kMaxTriangulationViews.
/// @param[in] anchor  the view whose inverse depth is asked for, < views.size().
/// @returns nullopt with too few or too many views, values that are not finite, parallax below
///          kMinTriangulationParallax_rad, or a point not in front of every camera.
[[nodiscard]] std::optional<TriangulatedPoint> triangulate(std::span<const BearingView> views,
                                                           std::size_t anchor = 0) noexcept;

}  // namespace pled
