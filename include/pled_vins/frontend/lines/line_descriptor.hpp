#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "pled_vins/core/image_view.hpp"
#include "pled_vins/frontend/lines/line_image.hpp"

namespace pled {

/// Bands along the line, and rows of pixels in each.
inline constexpr std::size_t kLineBands = 9;
inline constexpr std::size_t kBandRows = 7;
/// Numbers that tell of one band: means, then deviations, of four sums.
inline constexpr std::size_t kBandValues = 8;

/// Line band descriptor (Zhang & Koch, 2013): how grey changes along and across a line in nine
/// bands beside it. Means and deviations each have unit length before values are cut off at 0.4.
using LineBands = std::array<double, kLineBands * kBandValues>;

/// Its binary form: 32 pairs of bands compared value by value.
struct LineDescriptor {
  std::array<std::uint64_t, 4> bits{};

  friend bool operator==(const LineDescriptor&, const LineDescriptor&) = default;
};
inline constexpr int kDescriptorBits = 256;

/// Bits that differ.
[[nodiscard]] inline int distance(const LineDescriptor& a, const LineDescriptor& b) noexcept {
  int sum = 0;
  for (std::size_t i = 0; i < a.bits.size(); ++i) sum += std::popcount(a.bits[i] ^ b.bits[i]);
  return sum;
}

/// The bands of a line from `start` to `end`: 63 rows of pixels side by side with it, as many
/// pixels long as the line, at most kMaxRowPixels (beyond it in larger steps); nearest pixel, at
/// the border the outermost. Where nothing changes all values are 0. What scales all gradients
/// alike, and what turns them with the line, changes nothing.
/// Cost: 63 x length gradients read; no allocation.
[[nodiscard]] LineBands line_bands(ImageView<const GradientPixel> gradient,
                                   const Eigen::Vector2d& start_px,
                                   const Eigen::Vector2d& end_px) noexcept;
inline constexpr int kMaxRowPixels = 256;

/// Bit 8 p + v: value v of the pair's first band is larger than that of its second.
[[nodiscard]] LineDescriptor compare_bands(const LineBands& bands) noexcept;

}  // namespace pled
