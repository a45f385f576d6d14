#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "pled_vins/core/timestamp.hpp"
#include "pled_vins/geometry/warped_pixel.hpp"
#include "pled_vins/reliability/bin_clock.hpp"
#include "support/reliability/score_by_definition.hpp"

namespace pled::support {

/// A camera that turns at a constant rate before straight edges far away, some of which turn on
/// their own. Events come from integer pixels of a sensor without distortion; grid pixels are
/// sensor pixels plus limits::kMapMargin_px.
class RotatingEdges {
 public:
  static constexpr int kWidth_px = 240;
  static constexpr int kHeight_px = 180;
  static constexpr double kFocal_px = 200.0;
  static constexpr int kGridWidth_px = kWidth_px + 2 * limits::kMapMargin_px;
  static constexpr int kGridHeight_px = kHeight_px + 2 * limits::kMapMargin_px;

  /// @param rate_radps  of the camera, in its own frame
  RotatingEdges(const Eigen::Vector3d& rate_radps, Duration length, std::uint64_t seed);

  /// In the order of time; pixels of the sensor.
  [[nodiscard]] const std::vector<TimedPixel>& events() const { return events_; }

  /// Where the grid of the camera at t_to has what the sensor (pixel without margin) saw at t_from.
  [[nodiscard]] Eigen::Vector2d carry(const Eigen::Vector2d& sensor_px, Timestamp t_from,
                                      Timestamp t_to) const;
  /// The nearest pixel of the grid for an event; its place is moved by `shift_px` in x and y before
  /// it is rounded.
  [[nodiscard]] WarpedPixel warp(const TimedPixel& event, Timestamp t_to,
                                 double shift_px = 0.0) const;
  /// How far the centre of the picture is carried between the two times, px.
  [[nodiscard]] double shift_px(Timestamp t_from, Timestamp t_to) const;

 private:
  Eigen::Vector3d rate_radps_;
  std::vector<TimedPixel> events_;
};

/// Differences in s between two ways of compensating, over pixels with events.
struct Difference {
  std::size_t pixels = 0;
  double mean = 0.0;
  double p90 = 0.0;
  double above_tenth = 0.0;  ///< share of pixels that differ by more than 0.1
};

/// The map with anchors against warping the window anew at each frame, at the pixels of the sensor
/// that the latter has events for.
struct RewarpComparison {
  Difference anchored;
  /// The same between two re-warps of which one has its pixel grid 0.49 px further in x and y: what
  /// the place of the grid alone does.
  Difference half_pixel;
  Difference anchored_pooled;    ///< mean of the active pixels of 3 x 3 on both sides
  Difference half_pixel_pooled;  ///< the same
  std::size_t beyond_grid = 0;   ///< pixels that the anchor's grid does not have
  std::uint64_t anchors = 0;
};

[[nodiscard]] RewarpComparison compare_with_rewarp(const RotatingEdges& scene, Duration length,
                                                   std::int64_t frame_period_us);

}  // namespace pled::support
