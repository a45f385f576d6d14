#pragma once

#include <optional>

#include "pled_vins/backend/factors.hpp"
#include "pled_vins/backend/window.hpp"
#include "pled_vins/core/messages.hpp"

namespace pled {

/// Inverse depth of a point from known poses.
struct DepthEstimate {
  double inverse_depth_pm = 0.0;
  double information = 0.0;   ///< of the inverse depth, 1/(1/m)^2
  double mean_squared = 0.0;  ///< residual per sighting, sigmas^2 (2 expected)
};

/// Solves for the inverse depth along the anchor's bearing with all poses held: linear
/// start, then robust Gauss-Newton in one dimension. nullopt with fewer than two sightings or
/// a result that is not finite.
[[nodiscard]] std::optional<DepthEstimate> estimate_depth(const SlidingWindow& window,
                                                          const RigCalibration& rig,
                                                          const FactorSettings& settings,
                                                          const Landmark& landmark) noexcept;

/// Keeps the points of a window: who is seen, who has a depth, who is solved, who is wrong.
class LandmarkBook {
 public:
  LandmarkBook(const RigCalibration& rig, const FactorSettings& settings,
               std::size_t min_observations) noexcept
      : rig_(rig), settings_(settings), min_observations_(min_observations) {}

  /// Notes the points of a frame as seen from window state `state`; forgets points that ended
  /// and are seen from less than two states.
  void observe(SlidingWindow& window, const FrameMeasurement& frame,
               std::size_t state) const noexcept;

  /// Gives new points a depth, and picks those that take part in the next solve: at most
  /// limits::kMaxPoints, living and long ones first. Returns how many.
  std::size_t prepare(SlidingWindow& window) const noexcept;

  /// After a solve: weight of every point; those that do not fit are rejected. Returns the
  /// root of the mean squared residual in pixels of the frame camera (one axis) over the points
  /// that stay, 0 when there are none.
  double judge(SlidingWindow& window) const noexcept;

 private:
  [[nodiscard]] double median_inverse_depth(const SlidingWindow& window) const noexcept;
  void give_depth(SlidingWindow& window, Landmark& landmark, double scene_pm) const noexcept;

  const RigCalibration& rig_;
  const FactorSettings& settings_;
  std::size_t min_observations_;
};

}  // namespace pled
