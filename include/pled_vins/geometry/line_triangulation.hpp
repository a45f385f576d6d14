#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "pled_vins/geometry/line.hpp"
#include "pled_vins/geometry/triangulation.hpp"

namespace pled {

/// A piece of a line seen by one camera. Other views may see other pieces, with the ends in either
/// order: only the line through them counts.
struct SegmentView {
  Pose T_world_cam;
  Eigen::Vector2d start_xy = Eigen::Vector2d::Zero();  ///< undistorted, on the plane z = 1
  Eigen::Vector2d end_xy = Eigen::Vector2d::Zero();
};

/// What a line must show before it is believed. Ours; PL-VINS asks for 3.6 deg between two planes,
/// whatever the noise, and has no answer to a motion along the line.
struct LineTriangulationRules {
  /// Standard deviation of an end across its line, on the plane z = 1: sigma_px / f. > 0
  double sigma_xy = 0.005;
  /// Least angle between two of the planes through line and camera, at the line. > 0
  double min_angle_rad = 1e-3;
  /// Least distance of a camera from the plane that the longest segment spans with its own camera,
  /// in standard deviations: less is a motion along the line as far as can be told, and the ends'
  /// noise then feigns a line whose depths seem well known. > 0
  double min_baseline_sigmas = 4.0;
  /// Most uncertainty of the inverse depth of either end, in parts of the nearer end's. > 0
  double max_depth_sigma = 0.3;
};

struct TriangulatedLine {
  PluckerLine line_world;  ///< |d| = 1
  std::size_t view = 0;    ///< the view with the longest segment, whose ends follow
  Eigen::Vector3d start_world = Eigen::Vector3d::Zero();  ///< m
  Eigen::Vector3d end_world = Eigen::Vector3d::Zero();
  double angle_rad = 0.0;    ///< largest angle at the line between the planes of two cameras
  double depth_sigma = 0.0;  ///< the figure that max_depth_sigma bounds
  double rms_error = 0.0;    ///< root mean square distance of the ends seen, plane z = 1
};

/// The line that views[0..n) see pieces of, by least squares of the distances of their ends.
///
/// Each view spans a plane with its camera's centre. The inverse depths of the longest segment's
/// ends, linear in those planes, come first; then at most 8 Gauss-Newton steps in these and in the
/// ends' offsets across the segment, in which far lines stay well conditioned.
///
/// @param[in] views  2 to kMaxTriangulationViews.
/// @returns nullopt with too few or too many views, rules out of range, values that are not finite,
///          no segment longer than 4 sigma_xy; motion along the line, in its plane or by rotation
///          alone (min_baseline_sigmas); planes too close to parallel (min_angle_rad); depths too
///          uncertain; or a line that is not in front of the cameras: both ends of the longest
///          segment, the middle of every other.
/// Cost: O(n) a step, n^2 / 2 cross products; no allocation.
[[nodiscard]] std::optional<TriangulatedLine> triangulate_line(
    std::span<const SegmentView> views, const LineTriangulationRules& rules = {}) noexcept;

}  // namespace pled
