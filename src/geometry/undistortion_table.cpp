#include "pled_vins/geometry/undistortion_table.hpp"

#include <algorithm>
#include <limits>

namespace pled {

bool UndistortionTable::build(const Camera& camera, std::span<float> storage) noexcept {
  const int width_px = camera.calibration().width_px;
  const int height_px = camera.calibration().height_px;
  if (width_px < 1 || height_px < 1) return false;
  if (storage.size() < floats_needed(width_px, height_px)) return false;
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  std::size_t i = 0;
  std::size_t invalid = 0;
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      const std::optional<Eigen::Vector2d> b = camera.undistort(Eigen::Vector2d(x, y));
      if (!b) ++invalid;
      storage[i++] = b ? static_cast<float>(b->x()) : kNone;
      storage[i++] = b ? static_cast<float>(b->y()) : kNone;
    }
  }
  bearings_xy_ = storage.first(i);
  width_px_ = width_px;
  height_px_ = height_px;
  invalid_pixels_ = invalid;
  return true;
}

Eigen::Vector2f UndistortionTable::entry(int x_px, int y_px) const noexcept {
  const std::size_t i = 2 * (static_cast<std::size_t>(y_px) * static_cast<std::size_t>(width_px_) +
                             static_cast<std::size_t>(x_px));
  return {bearings_xy_[i], bearings_xy_[i + 1]};
}

std::optional<Eigen::Vector2f> UndistortionTable::at(int x_px, int y_px) const noexcept {
  if (x_px < 0 || y_px < 0 || x_px >= width_px_ || y_px >= height_px_) return std::nullopt;
  const Eigen::Vector2f b = entry(x_px, y_px);
  if (!b.allFinite()) return std::nullopt;
  return b;
}

std::optional<Eigen::Vector2f> UndistortionTable::lookup(float x_px, float y_px) const noexcept {
  const auto last_x = static_cast<float>(width_px_ - 1);
  const auto last_y = static_cast<float>(height_px_ - 1);
  if (!(x_px >= 0.0F && y_px >= 0.0F && x_px <= last_x && y_px <= last_y)) return std::nullopt;
  // On the last column or row the far neighbour has weight 0 and may be any pixel of the sensor.
  const int x0 = static_cast<int>(x_px);
  const int y0 = static_cast<int>(y_px);
  const int x1 = std::min(x0 + 1, width_px_ - 1);
  const int y1 = std::min(y0 + 1, height_px_ - 1);
  const float u = x_px - static_cast<float>(x0);
  const float v = y_px - static_cast<float>(y0);
  const Eigen::Vector2f b = (1.0F - v) * ((1.0F - u) * entry(x0, y0) + u * entry(x1, y0)) +
                            v * ((1.0F - u) * entry(x0, y1) + u * entry(x1, y1));
  if (!b.allFinite())
    return std::nullopt;  // a NaN neighbour makes the sum NaN, whatever its weight
  return b;
}

}  // namespace pled
