#include "pled_vins/frontend/pyramid.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include <doctest/doctest.h>

#include "support/frontend/plane_scene.hpp"

namespace pled {
namespace {

int clamped(const ImageView<std::int16_t>& level, int y, int x) {
  return level.at(std::clamp(y, 0, level.height - 1), std::clamp(x, 0, level.width - 1));
}

}  // namespace

TEST_SUITE("frontend.pyramid") {
  TEST_CASE(
      "levels equal their kernels and the margins repeat the border, for odd and even sizes") {
    for (const auto& [width, height] : {std::pair{62, 61}, std::pair{75, 64}}) {
      CAPTURE(width);
      std::mt19937_64 random(5);
      support::GreyImage image(width, height);
      for (std::uint8_t& v : image.pixels) v = static_cast<std::uint8_t>(random() % 256);
      std::vector<std::int16_t> memory(pyramid_values(width, height), -1);
      std::vector<std::uint16_t> row(static_cast<std::size_t>(padded_stride(width)));
      Pyramid pyramid = lay_out_pyramid(memory, width, height, limits::kMaxPyramidLevels);
      REQUIRE(pyramid.num_levels == 2);  // the third would be 16 pixels across
      build_pyramid(image.view(), row, pyramid);

      constexpr std::array<int, 3> kSmall{1, 2, 1};
      const ImageView<std::int16_t>& base = pyramid.levels[0];
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          int want = 0;
          for (int v = -1; v <= 1; ++v)
            for (int u = -1; u <= 1; ++u)
              want += kSmall[static_cast<std::size_t>(v + 1)] *
                      kSmall[static_cast<std::size_t>(u + 1)] *
                      image.at(std::clamp(y + v, 0, height - 1), std::clamp(x + u, 0, width - 1));
          CHECK(base.at(y, x) == want);
        }

      constexpr std::array<int, 5> kWide{1, 4, 6, 4, 1};
      const ImageView<std::int16_t>& half = pyramid.levels[1];
      CHECK(half.width == (width + 1) / 2);
      CHECK(half.height == (height + 1) / 2);
      for (int y = 0; y < half.height; ++y)
        for (int x = 0; x < half.width; ++x) {
          int sum = 0;
          for (int v = -2; v <= 2; ++v)
            for (int u = -2; u <= 2; ++u)
              sum += kWide[static_cast<std::size_t>(v + 2)] *
                     kWide[static_cast<std::size_t>(u + 2)] * clamped(base, 2 * y + v, 2 * x + u);
          CHECK(half.at(y, x) == (sum + 128) / 256);
        }
      for (const ImageView<std::int16_t>& level : {base, half})
        for (int y = -kPyramidPad; y < level.height + kPyramidPad; ++y)
          for (int x = -kPyramidPad; x < level.width + kPyramidPad; ++x)
            if (level.row(y)[x] != clamped(level, y, x)) FAIL_CHECK("margin differs");
    }
  }
}

}  // namespace pled
