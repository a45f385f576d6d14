#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "pled_vins/geometry/camera.hpp"

namespace pled {

/// Bearings of all pixels of a sensor, computed once: what an event stream needs, where Newton's
/// method for each event would be too dear. The memory is the caller's and must outlive the table.
class UndistortionTable {
 public:
  /// Floats that build() needs for a sensor.
  [[nodiscard]] static constexpr std::size_t floats_needed(int width_px, int height_px) noexcept {
    return 2 * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  }

  UndistortionTable() = default;

  /// Fills `storage` (row-major, x and y of each pixel in turn) with the camera's bearings. False,
  /// leaving table and storage as they were, when the camera has no pixels or the storage is too
  /// small. Cost: one Camera::undistort for each pixel.
  [[nodiscard]] bool build(const Camera& camera, std::span<float> storage) noexcept;

  [[nodiscard]] int width_px() const noexcept { return width_px_; }
  [[nodiscard]] int height_px() const noexcept { return height_px_; }
  /// Pixels of the sensor that have no bearing.
  [[nodiscard]] std::size_t invalid_pixels() const noexcept { return invalid_pixels_; }

  /// All bearings, row-major, x and y of each pixel in turn; NaN where there is none.
  [[nodiscard]] std::span<const float> bearings_xy() const noexcept { return bearings_xy_; }

  /// Bearing (x, y) on the plane z = 1 of an integer pixel; nullopt outside the sensor or where the
  /// lens model has none.
  [[nodiscard]] std::optional<Eigen::Vector2f> at(int x_px, int y_px) const noexcept;

  /// The same between pixels, bilinear; nullopt outside the outermost pixel centres or next to a
  /// pixel without bearing.
  [[nodiscard]] std::optional<Eigen::Vector2f> lookup(float x_px, float y_px) const noexcept;

 private:
  [[nodiscard]] Eigen::Vector2f entry(int x_px, int y_px) const noexcept;

  std::span<const float> bearings_xy_;  ///< NaN where there is no bearing
  int width_px_ = 0;
  int height_px_ = 0;
  std::size_t invalid_pixels_ = 0;
};

}  // namespace pled
