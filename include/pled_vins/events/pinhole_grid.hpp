#pragma once

#include <array>

namespace pled {

/// The pixels that compensated events are written to, as numbers to compute with. The same formula
/// serves one bearing (T = float) and several (T = a vector type), to the same bits.
struct PinholeGrid {
  float fx_px = 0.0F;
  float fy_px = 0.0F;
  float cx_px = 0.0F;  ///< half a pixel more than the calibration's: truncation then rounds
  float cy_px = 0.0F;
  float width_px = 0.0F;
  float height_px = 0.0F;

  /// A point on the grid; u and v are half a pixel more than its coordinates.
  template <typename T>
  struct Point {
    T u;
    T v;
    T z;  ///< in front of the camera where > 0
  };

  /// Bearing (bx, by, 1), turned by R (row-major), on the grid.
  template <typename T>
  [[nodiscard]] Point<T> project(const T& bx, const T& by,
                                 const std::array<float, 9>& R) const noexcept {
    const T z = R[6] * bx + R[7] * by + R[8];
    const T inverse = 1.0F / z;
    const T x = R[0] * bx + R[1] * by + R[2];
    const T y = R[3] * bx + R[4] * by + R[5];
    return {fx_px * x * inverse + cx_px, fy_px * y * inverse + cy_px, z};
  }

  /// Whether a point lies in front of the camera and on a pixel; false for NaN.
  [[nodiscard]] bool holds(const Point<float>& at) const noexcept {
    return at.z > 0.0F && at.u >= 0.0F && at.u < width_px && at.v >= 0.0F && at.v < height_px;
  }
};

}  // namespace pled
