#include "pled_vins/frontend/pyramid.hpp"

#include <algorithm>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

/// A level below this many pixels across is smaller than a patch and only misleads.
constexpr int kMinLevelSide = 30;

/// Copies the outermost pixels of a level into its margin.
void replicate_border(const ImageView<std::int16_t>& level) noexcept {
  for (int y = 0; y < level.height; ++y) {
    std::int16_t* row = level.row(y);
    std::fill(row - kPyramidPad, row, row[0]);
    std::fill(row + level.width, row - kPyramidPad + level.stride, row[level.width - 1]);
  }
  const std::int16_t* top = level.row(0) - kPyramidPad;
  const std::int16_t* bottom = level.row(level.height - 1) - kPyramidPad;
  for (int k = 1; k <= kPyramidPad; ++k) {
    std::copy_n(top, level.stride, level.row(-k) - kPyramidPad);
    std::copy_n(bottom, level.stride, level.row(level.height - 1 + k) - kPyramidPad);
  }
}

/// [1 2 1] x [1 2 1], without the division by 16.
void smooth_into(ImageView<const std::uint8_t> image, std::span<std::uint16_t> scratch,
                 const ImageView<std::int16_t>& out) noexcept {
  const int w = image.width;
  std::uint16_t* column = scratch.data() + 1;  // one value to spare on each side
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* above = image.row(std::max(y - 1, 0));
    const std::uint8_t* here = image.row(y);
    const std::uint8_t* below = image.row(std::min(y + 1, image.height - 1));
    for (int x = 0; x < w; ++x)
      column[x] = static_cast<std::uint16_t>(above[x] + 2 * here[x] + below[x]);
    column[-1] = column[0];
    column[w] = column[w - 1];
    std::int16_t* row = out.row(y);
    for (int x = 0; x < w; ++x)
      row[x] = static_cast<std::int16_t>(column[x - 1] + 2 * column[x] + column[x + 1]);
  }
}

/// Every second pixel of every second row after [1 4 6 4 1]/16 both ways, rounded.
void halve_into(const ImageView<std::int16_t>& in, std::span<std::uint16_t> scratch,
                const ImageView<std::int16_t>& out) noexcept {
  // The margin of `in` is filled, so rows and columns -2 ... +2 past the image exist.
  const int reach = in.width + 4;
  std::uint16_t* column = scratch.data();
  for (int y = 0; y < out.height; ++y) {
    const std::int16_t* r0 = in.row(2 * y - 2) - 2;
    const std::int16_t* r1 = in.row(2 * y - 1) - 2;
    const std::int16_t* r2 = in.row(2 * y) - 2;
    const std::int16_t* r3 = in.row(2 * y + 1) - 2;
    const std::int16_t* r4 = in.row(2 * y + 2) - 2;
    for (int x = 0; x < reach; ++x)  // at most 255 x 16 x 16 = 65280
      column[x] = static_cast<std::uint16_t>(r0[x] + r4[x] + 4 * (r1[x] + r3[x]) + 6 * r2[x]);
    std::int16_t* row = out.row(y);
    for (int x = 0; x < out.width; ++x) {
      const std::uint16_t* c = column + 2 * x;
      const int sum = c[0] + c[4] + 4 * (c[1] + c[3]) + 6 * c[2];
      row[x] = static_cast<std::int16_t>((sum + 128) >> 8);
    }
  }
}

}  // namespace

Pyramid lay_out_pyramid(std::span<std::int16_t> memory, int width_px, int height_px,
                        int max_levels) noexcept {
  PLED_CHECK(memory.size() >= pyramid_values(width_px, height_px));
  Pyramid pyramid;
  std::int16_t* next = memory.data();
  while (pyramid.num_levels < std::min(max_levels, limits::kMaxPyramidLevels)) {
    if (pyramid.num_levels > 0 && std::min(width_px, height_px) < kMinLevelSide) break;
    const int stride = padded_stride(width_px);
    std::int16_t* origin = next + static_cast<std::ptrdiff_t>(kPyramidPad) * stride + kPyramidPad;
    pyramid.levels[static_cast<std::size_t>(pyramid.num_levels)] = {origin, width_px, height_px,
                                                                    stride};
    next += static_cast<std::ptrdiff_t>(stride) * (height_px + 2 * kPyramidPad);
    width_px = (width_px + 1) / 2;
    height_px = (height_px + 1) / 2;
    ++pyramid.num_levels;
  }
  return pyramid;
}

void build_pyramid(ImageView<const std::uint8_t> image, std::span<std::uint16_t> scratch,
                   Pyramid& pyramid) noexcept {
  PLED_CHECK(pyramid.num_levels > 0 && image.width == pyramid.levels[0].width &&
             image.height == pyramid.levels[0].height);
  PLED_CHECK(scratch.size() >= static_cast<std::size_t>(padded_stride(image.width)));
  smooth_into(image, scratch, pyramid.levels[0]);
  replicate_border(pyramid.levels[0]);
  for (std::size_t l = 1; l < static_cast<std::size_t>(pyramid.num_levels); ++l) {
    halve_into(pyramid.levels[l - 1], scratch, pyramid.levels[l]);
    replicate_border(pyramid.levels[l]);
  }
}

}  // namespace pled
