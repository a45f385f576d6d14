#include "pled_vins/frontend/lines/line_descriptor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "support/frontend/drawn_edges.hpp"

namespace pled {
namespace {

using support::GreyImage;

struct Gradients {
  int width;
  int height;
  std::vector<GradientPixel> pixels;
  explicit Gradients(const GreyImage& image)
      : width(image.width), height(image.height), pixels(image.pixels.size()) {
    sobel(image.view(), {pixels.data(), width, height, width});
  }
  [[nodiscard]] ImageView<const GradientPixel> view() const {
    return {pixels.data(), width, height, width};
  }
  [[nodiscard]] LineDescriptor describe(const Eigen::Vector2d& from,
                                        const Eigen::Vector2d& to) const {
    return compare_bands(line_bands(view(), from, to));
  }
};

/// The four sums of row k, from the definition.
std::array<double, 4> row_by_definition(const Gradients& g, const Eigen::Vector2d& from,
                                        const Eigen::Vector2d& to, int k) {
  const double length = (to - from).norm();
  const Eigen::Vector2d along = (to - from) / length;
  const Eigen::Vector2d across(-along.y(), along.x());
  const auto n = static_cast<int>(std::lround(length));
  std::array<double, 4> v{};
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector2d at = 0.5 * (from + to) + (i - 0.5 * (n - 1)) * along + (k - 31) * across;
    const int x = std::clamp(static_cast<int>(std::lround(at.x())), 0, g.width - 1);
    const int y = std::clamp(static_cast<int>(std::lround(at.y())), 0, g.height - 1);
    const GradientPixel& p = g.pixels[static_cast<std::size_t>(y * g.width + x)];
    const double a = Eigen::Vector2d(p.x, p.y).dot(along);
    const double c = Eigen::Vector2d(p.x, p.y).dot(across);
    v[0] += a > 0 ? a : 0;
    v[1] += a < 0 ? -a : 0;
    v[2] += c > 0 ? c : 0;
    v[3] += c < 0 ? -c : 0;
  }
  return v;
}

/// Nine bands by the definition: each from its own rows and those of its neighbours.
LineBands bands_by_definition(const Gradients& g, const Eigen::Vector2d& from,
                              const Eigen::Vector2d& to) {
  std::array<std::array<double, 8>, 9> band{};
  for (int b = 0; b < 9; ++b) {
    std::array<double, 4> sum{};
    std::array<double, 4> square{};
    int rows = 0;
    for (int j = 0; j < 21; ++j) {
      const int k = 7 * (b - 1) + j;
      if (k < 0 || k > 62) continue;
      ++rows;
      const double local = std::exp(-(j - 10.0) * (j - 10.0) / (2.0 * 49.0));
      const double global = std::exp(-(k - 31.0) * (k - 31.0) / (2.0 * 31.0 * 31.0));
      const std::array<double, 4> v = row_by_definition(g, from, to, k);
      for (std::size_t s = 0; s < 4; ++s) {
        sum[s] += local * global * v[s];
        square[s] += std::pow(local * global * v[s], 2.0);
      }
    }
    for (std::size_t s = 0; s < 4; ++s) {
      auto& out = band[static_cast<std::size_t>(b)];
      out[s] = sum[s] / rows;
      out[4 + s] = std::sqrt(std::max(0.0, square[s] / rows - out[s] * out[s]));
    }
  }
  for (const std::size_t half : {0U, 4U}) {
    double square = 0.0;
    for (const auto& b : band)
      for (std::size_t s = 0; s < 4; ++s) square += b[half + s] * b[half + s];
    for (auto& b : band)
      for (std::size_t s = 0; s < 4; ++s) b[half + s] /= std::sqrt(square);
  }
  LineBands out{};
  double square = 0.0;
  for (std::size_t b = 0; b < 9; ++b)
    for (std::size_t s = 0; s < 8; ++s) {
      out[8 * b + s] = std::min(0.4, band[b][s]);
      square += out[8 * b + s] * out[8 * b + s];
    }
  for (double& v : out) v /= std::sqrt(square);
  return out;
}

GreyImage texture(std::uint64_t seed, double turn_rad = 0.0, double gain = 200.0,
                  double offset = 20.0) {
  const support::Texture wave(seed, 9.0, 60.0);
  const double c = std::cos(turn_rad);
  const double s = std::sin(turn_rad);
  return support::draw(240, 180, [&](double x, double y) {
    const double u = x - 119.5;
    const double v = y - 89.5;
    return offset + gain * wave(c * u + s * v, -s * u + c * v);
  });
}

}  // namespace

TEST_SUITE("frontend.line_descriptor") {
  TEST_CASE("bands are those of the definition, wherever the line lies") {
    std::mt19937_64 random(5);
    const Gradients g(texture(1));
    for (int i = 0; i < 60; ++i) {
      CAPTURE(i);
      Eigen::Vector2d from(240 * support::uniform(random), 180 * support::uniform(random));
      Eigen::Vector2d to(240 * support::uniform(random), 180 * support::uniform(random));
      if ((to - from).norm() < 3.0) continue;
      const LineBands got = line_bands(g.view(), from, to);
      const LineBands want = bands_by_definition(g, from, to);
      double worst = 0.0;
      for (std::size_t k = 0; k < got.size(); ++k)
        worst = std::max(worst, std::abs(got[k] - want[k]));
      CHECK(worst < 1e-9);
      CHECK(compare_bands(got) == compare_bands(want));
    }
  }

  TEST_CASE("bit 8 p + v says whether value v of pair p's first band is the larger") {
    LineBands bands{};
    bands[0 * 8 + 3] = 1.0;  // of band 0: first in pairs 0 to 5
    const LineDescriptor zero = compare_bands(bands);
    LineDescriptor want;
    for (int p = 0; p < 6; ++p) want.bits[0] |= std::uint64_t{1} << (8 * p + 3);
    CHECK(zero == want);
    bands = {};
    bands[8 * 8 + 7] = 1.0;  // band 8 is never first
    CHECK(compare_bands(bands) == LineDescriptor{});
    bands = {};
    bands[7 * 8 + 7] = 1.0;  // band 7 only in the last pair, (7, 8)
    want = {};
    want.bits[3] = std::uint64_t{1} << 63;
    CHECK(compare_bands(bands) == want);
    CHECK(distance(zero, want) == 7);
  }

  TEST_CASE("a quarter turn of picture and line changes no bit") {
    const GreyImage image = texture(2);
    GreyImage turned(180, 240);
    for (int y = 0; y < 180; ++y)
      for (int x = 0; x < 240; ++x) turned.at(x, 179 - y) = image.view().at(y, x);
    const Gradients g(image);
    const Gradients g_turned(turned);
    std::mt19937_64 random(6);
    for (int i = 0; i < 30; ++i) {
      const Eigen::Vector2d from(240 * support::uniform(random), 180 * support::uniform(random));
      const Eigen::Vector2d to(240 * support::uniform(random), 180 * support::uniform(random));
      CHECK(g.describe(from, to) ==
            g_turned.describe({179 - from.y(), from.x()}, {179 - to.y(), to.x()}));
    }
  }

  TEST_CASE("twice the contrast changes no bit, another gain and any offset few") {
    const Gradients g(texture(3, 0.0, 100.0, 10.0));
    GreyImage doubled = texture(3, 0.0, 100.0, 10.0);
    for (std::uint8_t& p : doubled.pixels) p = static_cast<std::uint8_t>(2 * p);
    const Gradients g_doubled(doubled);
    const Gradients g_other(texture(3, 0.0, 150.0, 60.0));
    std::mt19937_64 random(7);
    for (int i = 0; i < 30; ++i) {
      const Eigen::Vector2d from(40 + 160 * support::uniform(random),
                                 40 + 100 * support::uniform(random));
      const Eigen::Vector2d to(40 + 160 * support::uniform(random),
                               40 + 100 * support::uniform(random));
      if ((to - from).norm() < 20.0) continue;
      CHECK(g.describe(from, to) == g_doubled.describe(from, to));
      CHECK(distance(g.describe(from, to), g_other.describe(from, to)) <= 12);
    }
  }

  TEST_CASE("a line that turns with its picture stays far more alike than it is to other lines") {
    const double turn = 20.0 * std::numbers::pi / 180.0;
    const Gradients g(texture(4));
    const Gradients g_turned(texture(4, turn));
    const Eigen::Vector2d middle(119.5, 89.5);
    const auto turned = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
      const Eigen::Vector2d d = p - middle;
      return middle + Eigen::Vector2d(std::cos(turn) * d.x() - std::sin(turn) * d.y(),
                                      std::sin(turn) * d.x() + std::cos(turn) * d.y());
    };
    std::mt19937_64 random(8);
    int same = 0;
    int other = 0;
    int lines = 0;
    for (int i = 0; i < 40; ++i) {
      const auto place = [&] {
        return Eigen::Vector2d(80 + 80 * support::uniform(random),
                               60 + 60 * support::uniform(random));
      };
      const Eigen::Vector2d from = place();
      const Eigen::Vector2d to = place();
      if ((to - from).norm() < 25.0) continue;
      ++lines;
      const LineDescriptor here = g.describe(from, to);
      same += distance(here, g_turned.describe(turned(from), turned(to)));
      other += distance(here, g.describe(place(), place()));
    }
    REQUIRE(lines > 15);
    CHECK(same < 25 * lines);
    CHECK(other > 60 * lines);
  }

  TEST_CASE("where nothing changes, and of a line without length, all is zero") {
    const Gradients g(GreyImage(60, 40));
    for (const double v : line_bands(g.view(), {10, 10}, {50, 30})) CHECK(v == 0.0);
    const Gradients textured(texture(1));
    for (const double v : line_bands(textured.view(), {10, 10}, {10, 10})) CHECK(v == 0.0);
    CHECK(g.describe({10, 10}, {50, 30}) == LineDescriptor{});
  }

  TEST_CASE("a line longer than rows are read is read in larger steps") {
    const GreyImage image = support::draw(900, 80, [](double x, double y) {
      return 120.0 + 80.0 * std::sin(0.05 * x) + (y > 40 ? 40.0 : 0.0);
    });
    const Gradients g(image);
    double square = 0.0;
    for (const double v : line_bands(g.view(), {20, 40}, {880, 40})) {
      CHECK(std::isfinite(v));
      square += v * v;
    }
    CHECK(square == doctest::Approx(1.0));
  }
}

}  // namespace pled
