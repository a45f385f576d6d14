#include "pled_vins/frontend/corners.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Eigenvalues>
#include <doctest/doctest.h>

#include "pled_vins/frontend/pyramid.hpp"
#include "support/frontend/plane_scene.hpp"

namespace pled {

TEST_SUITE("frontend.corners") {
  TEST_CASE("the response is the smaller eigenvalue of the mean structure tensor, at every pixel") {
    for (const int width : {37, 40, 61}) {
      CAPTURE(width);
      const int height = 33;
      std::mt19937_64 random(static_cast<std::uint64_t>(width));
      support::GreyImage image(width, height);
      for (std::uint8_t& v : image.pixels) v = static_cast<std::uint8_t>(random() % 256);
      std::vector<std::int16_t> memory(pyramid_values(width, height));
      std::vector<std::uint16_t> row(static_cast<std::size_t>(padded_stride(width)));
      Pyramid pyramid = lay_out_pyramid(memory, width, height, 1);
      build_pyramid(image.view(), row, pyramid);
      const ImageView<const std::int16_t> level = pyramid.levels[0];

      std::vector<float> scratch(kCornerScratchRows * static_cast<std::size_t>(width));
      std::vector<float> response(static_cast<std::size_t>(width * height),
                                  std::numeric_limits<float>::quiet_NaN());
      corner_response(level, scratch, {response.data(), width, height, width});

      constexpr int k = kCornerWindowRadius;
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const float got = response[static_cast<std::size_t>(y * width + x)];
          if (x < kCornerBorderPx || y < kCornerBorderPx || x >= width - kCornerBorderPx ||
              y >= height - kCornerBorderPx) {
            CHECK(got == 0.0F);
            continue;
          }
          Eigen::Matrix2d S = Eigen::Matrix2d::Zero();
          for (int v = y - k; v <= y + k; ++v)
            for (int u = x - k; u <= x + k; ++u) {
              const Eigen::Vector2d g(level.at(v, u + 1) - level.at(v, u - 1),
                                      level.at(v + 1, u) - level.at(v - 1, u));
              S += g * g.transpose() / (4.0 * kPyramidScale * kPyramidScale);
            }
          S /= (2 * k + 1) * (2 * k + 1);
          const double want = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(S).eigenvalues()(0);
          CHECK(static_cast<double>(got) == doctest::Approx(want).epsilon(1e-4));
        }
      }
    }
  }

  TEST_CASE("a disc covers exactly the pixels within its radius") {
    std::vector<std::uint8_t> memory(30 * 20, 0);
    const ImageView<std::uint8_t> mask{memory.data(), 30, 20, 30};
    paint_disc(mask, 5.3F, 17.8F, 6.0F);
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 30; ++x)
        CHECK((mask.at(y, x) != 0) == (std::hypot(x - 5.3, y - 17.8) <= 6.0));
  }
}

}  // namespace pled
