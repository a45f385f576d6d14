#include "src/sim/texture.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace pled::sim {
namespace {

/// log2(x) for x > 0, linear between powers of two: continuous, at most 0.09 too low.
/// Only chooses how much to average, so that is enough.
float rough_log2(float x) noexcept {
  const auto bits = static_cast<float>(std::bit_cast<std::uint32_t>(x));
  return bits * 0x1.0p-23F - 127.0F;
}

}  // namespace

Texture::Texture(double width_m, double height_m, double texel_m)
    : texel_m_(static_cast<float>(texel_m)) {
  int width = std::max(1, static_cast<int>(std::ceil(width_m / texel_m)));
  int height = std::max(1, static_cast<int>(std::ceil(height_m / texel_m)));
  std::size_t first = 0;
  float per_m = 1.0F / texel_m_;
  for (;;) {
    levels_.push_back({first, width, height, per_m});
    first += static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    if (width == 1 && height == 1) break;
    width = (width + 1) / 2;
    height = (height + 1) / 2;
    per_m *= 0.5F;
  }
  texels_.assign(first, 0.5F);
}

Texture Texture::repeating(int texels, double texel_m) {
  Texture texture(texels * texel_m, texels * texel_m, texel_m);
  texture.repeats_ = true;
  return texture;
}

void Texture::build_levels() {
  for (std::size_t k = 1; k < levels_.size(); ++k) {
    const Level& fine = levels_[k - 1];
    const Level& coarse = levels_[k];
    const auto texel = [&](int y, int x) {
      const int yy = std::min(y, fine.height - 1);
      const int xx = std::min(x, fine.width - 1);
      return texels_[fine.first +
                     static_cast<std::size_t>(yy) * static_cast<std::size_t>(fine.width) +
                     static_cast<std::size_t>(xx)];
    };
    std::size_t out = coarse.first;
    for (int y = 0; y < coarse.height; ++y) {
      for (int x = 0; x < coarse.width; ++x) {
        texels_[out++] = 0.25F * (texel(2 * y, 2 * x) + texel(2 * y, 2 * x + 1) +
                                  texel(2 * y + 1, 2 * x) + texel(2 * y + 1, 2 * x + 1));
      }
    }
  }
}

float Texture::bilinear(const Level& level, float u_m, float v_m) const noexcept {
  float x = u_m * level.per_m - 0.5F;
  float y = v_m * level.per_m - 0.5F;
  if (repeats_) {
    x -= static_cast<float>(level.width) * std::floor(x / static_cast<float>(level.width));
    y -= static_cast<float>(level.height) * std::floor(y / static_cast<float>(level.height));
  }
  x = std::clamp(x, 0.0F, static_cast<float>(level.width) - (repeats_ ? 1e-3F : 1.0F));
  y = std::clamp(y, 0.0F, static_cast<float>(level.height) - (repeats_ ? 1e-3F : 1.0F));
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  // To the neighbour: none at the edge, or, when the picture repeats, the one at its other end.
  const auto width = static_cast<std::ptrdiff_t>(level.width);
  const std::ptrdiff_t back_x = repeats_ ? 1 - width : 0;
  const std::ptrdiff_t back_y =
      repeats_ ? (1 - static_cast<std::ptrdiff_t>(level.height)) * width : 0;
  const std::ptrdiff_t step_x = x0 + 1 < level.width ? 1 : back_x;
  const std::ptrdiff_t step_y = y0 + 1 < level.height ? width : back_y;
  const float ax = x - static_cast<float>(x0);
  const float ay = y - static_cast<float>(y0);
  const float* p = texels_.data() + level.first +
                   static_cast<std::size_t>(y0) * static_cast<std::size_t>(level.width) +
                   static_cast<std::size_t>(x0);
  const float top = p[0] + ax * (p[step_x] - p[0]);
  const float bottom = p[step_y] + ax * (p[step_y + step_x] - p[step_y]);
  return top + ay * (bottom - top);
}

float Texture::sample(float u_m, float v_m, float area_m2) const noexcept {
  const auto last = static_cast<float>(levels_.size() - 1);
  const float per_m = levels_.front().per_m;
  const float level = std::clamp(0.5F * rough_log2(area_m2 * per_m * per_m), 0.0F, last);
  const auto fine = static_cast<std::size_t>(level);
  const float between = level - static_cast<float>(fine);
  const float a = bilinear(levels_[fine], u_m, v_m);
  if (!(between > 0.0F)) return a;
  return a + between * (bilinear(levels_[fine + 1], u_m, v_m) - a);
}

}  // namespace pled::sim
