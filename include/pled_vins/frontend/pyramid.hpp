#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "pled_vins/core/image_view.hpp"
#include "pled_vins/core/limits.hpp"

namespace pled {

/// Replicated pixels on every side of a pyramid level, so that a patch around any pixel of the
/// image, and the vector loads that run past it, stay in our memory.
inline constexpr int kPyramidPad = 24;

/// Pyramid values are grey x 16: the kernel [1 2 1] x [1 2 1] without its division, so exact.
inline constexpr int kPyramidScale = 16;

/// Values from one row of a padded level to the next.
[[nodiscard]] constexpr int padded_stride(int width_px) noexcept {
  return (width_px + 2 * kPyramidPad + 7) / 8 * 8;
}

/// Values that a pyramid of kMaxPyramidLevels levels needs.
[[nodiscard]] constexpr std::size_t pyramid_values(int width_px, int height_px) noexcept {
  std::size_t sum = 0;
  for (int level = 0; level < limits::kMaxPyramidLevels; ++level) {
    sum += static_cast<std::size_t>(padded_stride(width_px)) *
           static_cast<std::size_t>(height_px + 2 * kPyramidPad);
    width_px = (width_px + 1) / 2;
    height_px = (height_px + 1) / 2;
  }
  return sum;
}

/// A smoothed image and its halvings. Pixel (x, y) of level l lies at (2x, 2y) of level l - 1,
/// so coordinates divide by two without an offset.
struct Pyramid {
  std::array<ImageView<std::int16_t>, limits::kMaxPyramidLevels> levels{};
  int num_levels = 0;
};

/// Lays a pyramid for images of the given size out in `memory`, which must hold
/// pyramid_values(width_px, height_px). Levels whose shorter side would be below 30 px are left
/// out.
[[nodiscard]] Pyramid lay_out_pyramid(std::span<std::int16_t> memory, int width_px, int height_px,
                                      int max_levels) noexcept;

/// Fills all levels, borders included. `image` has the size of level 0; `scratch` holds at least
/// padded_stride(width) values. Level 0 is the image smoothed by [1 2 1]/4 both ways, the next are
/// halved after [1 4 6 4 1]/16 both ways.
void build_pyramid(ImageView<const std::uint8_t> image, std::span<std::uint16_t> scratch,
                   Pyramid& pyramid) noexcept;

}  // namespace pled
