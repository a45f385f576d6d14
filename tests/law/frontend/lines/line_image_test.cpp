#include "pled_vins/frontend/lines/line_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "support/frontend/plane_scene.hpp"

namespace pled {
namespace {

using support::GreyImage;

GreyImage random_image(int width, int height, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  GreyImage image(width, height);
  for (std::uint8_t& p : image.pixels) p = static_cast<std::uint8_t>(random() % 256);
  return image;
}

int clamped(GreyImage& image, int y, int x) {
  return image.at(std::clamp(y, 0, image.height - 1), std::clamp(x, 0, image.width - 1));
}

}  // namespace

TEST_SUITE("frontend.line_image") {
  TEST_CASE("the median is that of the nine sorted pixels") {
    GreyImage in = random_image(37, 23, 1);
    GreyImage out = random_image(37, 23, 2);
    median_3x3(in.view(), {out.pixels.data(), 37, 23, 37});
    for (int y = 0; y < 23; ++y)
      for (int x = 0; x < 37; ++x) {
        std::array<int, 9> v;
        for (int k = 0; k < 9; ++k)
          v[static_cast<std::size_t>(k)] = clamped(in, y + k / 3 - 1, x + k % 3 - 1);
        std::sort(v.begin(), v.end());
        CHECK(int{out.at(y, x)} == v[4]);
      }
  }

  TEST_CASE("gradients are Sobel's of the definition") {
    GreyImage in = random_image(29, 17, 3);
    std::vector<GradientPixel> out(29 * 17, GradientPixel{12345, 12345});
    sobel(in.view(), {out.data(), 29, 17, 29});
    constexpr std::array<int, 3> kSmooth{1, 2, 1};
    for (int y = 0; y < 17; ++y)
      for (int x = 0; x < 29; ++x) {
        int gx = 0;
        int gy = 0;
        for (int k = -1; k <= 1; ++k) {
          const int w = kSmooth[static_cast<std::size_t>(k + 1)];
          gx += w * (clamped(in, y + k, x + 1) - clamped(in, y + k, x - 1));
          gy += w * (clamped(in, y + 1, x + k) - clamped(in, y - 1, x + k));
        }
        const GradientPixel got = out[static_cast<std::size_t>(y * 29 + x)];
        CHECK(int{got.x} == gx);
        CHECK(int{got.y} == gy);
      }
  }

  TEST_CASE("shrinking is the Gaussian mean about each pixel's middle, within rounding") {
    for (const auto& [width, height] : {std::pair{43, 31}, std::pair{16, 16}, std::pair{50, 40}}) {
      GreyImage in = random_image(width, height, 4);
      const int w = shrunk_px(width);
      const int h = shrunk_px(height);
      GreyImage out(w, h);
      std::vector<float> row(static_cast<std::size_t>(width), 1e9F);
      shrink(in.view(), row, {out.pixels.data(), w, h, w});
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
          const double cx = (x + 0.5) / 0.8 - 0.5;
          const double cy = (y + 0.5) / 0.8 - 0.5;
          const double sigma = 0.6 / 0.8;
          double sum = 0.0;
          double weights = 0.0;
          for (int v = static_cast<int>(cy) - 8; v <= static_cast<int>(cy) + 8; ++v)
            for (int u = static_cast<int>(cx) - 8; u <= static_cast<int>(cx) + 8; ++u) {
              const double g =
                  std::exp(-0.5 * ((u - cx) * (u - cx) + (v - cy) * (v - cy)) / (sigma * sigma));
              weights += g;
              sum += g * clamped(in, v, u);
            }
          CHECK(std::abs(out.at(y, x) - sum / weights) < 0.6);
        }
    }
  }

  TEST_CASE("a ramp's gradient between pixels is that of the ramp") {
    GreyImage in(32, 32);
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) in.at(y, x) = static_cast<std::uint8_t>(3 * x + 2 * y);
    std::vector<GradientPixel> out(32 * 32);
    const ImageView<GradientPixel> view{out.data(), 32, 32, 32};
    sobel(in.view(), view);
    const Eigen::Vector2d g = gradient_at(view, {12.3, 20.8}) / kSobelUnit;
    CHECK(g.x() == doctest::Approx(3.0));
    CHECK(g.y() == doctest::Approx(2.0));
    CHECK(gradient_at(view, {31.0, 31.0}).allFinite());
  }
}

}  // namespace pled
