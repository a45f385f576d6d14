#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "pled_vins/core/image_view.hpp"

namespace pled {

/// Sobel's 3 x 3 gradient of grey: eight times the slope a pixel.
struct GradientPixel {
  std::int16_t x = 0;
  std::int16_t y = 0;
};
/// What divides a Sobel gradient to grey per pixel.
inline constexpr double kSobelUnit = 8.0;

/// The part of a pixel that one pixel of the shrunk picture is long, and its blur in those pixels:
/// LSD's `scale` and `sigma_scale` (von Gioi et al., IPOL 2012).
inline constexpr double kLineScale = 0.8;
inline constexpr double kLineSigma = 0.6;
/// Width or height of the shrunk picture.
[[nodiscard]] constexpr int shrunk_px(int size_px) noexcept { return size_px * 4 / 5; }

/// Median of 3 x 3, the edge's pixels repeated. Both views have one size; they do not overlap.
void median_3x3(ImageView<const std::uint8_t> in, ImageView<std::uint8_t> out) noexcept;

/// Gaussian blur of kLineSigma / kLineScale and reduction to kLineScale in one, as LSD does it
/// before it looks for edges: pixel x of `out` is centred on (x + 0.5) / kLineScale - 0.5. The
/// edge's pixels are repeated. `out` has shrunk_px() of both sizes; `row` holds in.width floats.
/// Ours instead of OpenCV's: no memory of its own, no threads, and no shift by part of a pixel.
void shrink(ImageView<const std::uint8_t> in, std::span<float> row,
            ImageView<std::uint8_t> out) noexcept;

/// Sobel gradients of one picture in another of the same size; the edge's pixels repeated.
void sobel(ImageView<const std::uint8_t> in, ImageView<GradientPixel> out) noexcept;

/// Gradient between pixels, bilinear. The place is inside the outermost pixel centres.
[[nodiscard]] Eigen::Vector2d gradient_at(ImageView<const GradientPixel> gradient,
                                          const Eigen::Vector2d& px) noexcept;

}  // namespace pled
