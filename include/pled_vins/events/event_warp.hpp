#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/events/pinhole_grid.hpp"
#include "pled_vins/events/turn_history.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/geometry/undistortion_table.hpp"
#include "pled_vins/geometry/warped_pixel.hpp"

namespace pled {

/// Inside a slice a carried point may be this far from where exact rotation has it, pixels.
inline constexpr double kMaxSliceError_px = 0.08;

/// The camera whose pixels compensated events are written to: like `camera`, but a lens without
/// distortion, and `margin_px` more pixels on each side.
[[nodiscard]] CameraCalibration rectified(const CameraCalibration& camera,
                                          int margin_px = 0) noexcept;

/// Carries events to where their edge would be seen at one instant if the camera had only turned:
/// b' = R b, x' = K b' / z'. Translation is left in, as depth is unknown. Borrows the table.
class EventWarp {
 public:
  EventWarp() = default;
  /// @param[in] table  bearings of the sensor's pixels; its storage must outlive the object
  /// @param[in] grid  pinhole without distortion, e.g. rectified(); up to 16384 pixels a side
  /// @returns false, with the object as it was, when a size does not fit or grid has distortion.
  [[nodiscard]] bool build(const UndistortionTable& table, const CameraCalibration& grid) noexcept;

  [[nodiscard]] int sensor_width_px() const noexcept { return sensor_width_px_; }
  [[nodiscard]] int sensor_height_px() const noexcept { return sensor_height_px_; }
  /// Of the grid.
  [[nodiscard]] int width_px() const noexcept { return width_px_; }
  [[nodiscard]] int height_px() const noexcept { return height_px_; }
  /// What TurnHistory::slices() may be given so that kMaxSliceError_px holds all over the grid (up
  /// to 45 degrees off the axis).
  [[nodiscard]] double slice_error_rad() const noexcept { return slice_error_rad_; }

  /// Pixel of the grid for each event, kOutsideGrid for those that miss it, come from no pixel of
  /// the sensor, from one without bearing, or from a time without slice. `out` holds at least as
  /// many as `events`. Splitting the events anyhow gives the same pixels.
  /// Cost: about 20 instructions an event; four at a time.
  void warp(std::span<const Event> events, const TurnSlices& slices,
            std::span<WarpedPixel> out) const noexcept;

  /// Where the grid has a pixel of the sensor (inside it) seen in a slice (< slices.count), not
  /// rounded; nullopt where warp() would say kOutsideGrid.
  [[nodiscard]] std::optional<Eigen::Vector2f> carry_pixel(std::size_t pixel_index,
                                                           const TurnSlices& slices,
                                                           std::size_t slice) const noexcept {
    return carry_bearing(bearings_xy_[2 * pixel_index], bearings_xy_[2 * pixel_index + 1],
                         slices.R_ref_slice[slice]);
  }

  /// The same for any point of the raw picture at a time.
  [[nodiscard]] std::optional<Eigen::Vector2f> carry(const Eigen::Vector2f& raw_px, Timestamp t,
                                                     const TurnSlices& slices) const noexcept;

 private:
  [[nodiscard]] std::optional<Eigen::Vector2f> carry_bearing(
      float bx, float by, const std::array<float, 9>& R) const noexcept {
    const PinholeGrid::Point<float> at = grid_.project(bx, by, R);
    if (!grid_.holds(at)) return std::nullopt;
    return Eigen::Vector2f(at.u - 0.5F, at.v - 0.5F);
  }
  void warp_slice(std::span<const Event> events, const std::array<float, 9>& R,
                  std::span<WarpedPixel> out) const noexcept;

  UndistortionTable table_;
  const float* bearings_xy_ = nullptr;
  int sensor_width_px_ = 0;
  int sensor_height_px_ = 0;
  int width_px_ = 0;
  int height_px_ = 0;
  PinholeGrid grid_;
  double slice_error_rad_ = 0.0;
};

}  // namespace pled
