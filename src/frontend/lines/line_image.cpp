#include "pled_vins/frontend/lines/line_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

/// Beyond three decades of the Gaussian, LSD's own choice: 3 px.
constexpr int kReach = 3;
/// Source pixels that one pixel of the shrunk picture takes from.
constexpr int kTaps = 2 * kReach + 2;

/// Four pixels of the shrunk picture take the room of five, and the next four take alike.
constexpr int kPhases = 4;
constexpr int kPeriod = 5;

/// Where one row or column of the shrunk picture takes from, and by how much.
struct Taps {
  int first = 0;
  std::array<float, kTaps> weight{};
};

Taps taps_of(int index) noexcept {
  const double centre = (index + 0.5) / kLineScale - 0.5;
  const double sigma = kLineSigma / kLineScale;
  Taps taps;
  taps.first = static_cast<int>(std::floor(centre)) - kReach;
  std::array<double, kTaps> weight;
  double sum = 0.0;
  for (int k = 0; k < kTaps; ++k) {
    const double d = (taps.first + k - centre) / sigma;
    weight[static_cast<std::size_t>(k)] = std::exp(-0.5 * d * d);
    sum += weight[static_cast<std::size_t>(k)];
  }
  for (std::size_t k = 0; k < kTaps; ++k) taps.weight[k] = static_cast<float>(weight[k] / sum);
  return taps;
}

/// @param from  kTaps values
std::uint8_t weighted(const Taps& taps, const float* from) noexcept {
  float sum = 0.5F;  // truncation then rounds
  for (std::size_t k = 0; k < kTaps; ++k) sum += taps.weight[k] * from[k];
  return static_cast<std::uint8_t>(sum);
}

std::uint8_t median(std::uint8_t a, std::uint8_t b, std::uint8_t c) noexcept {
  return std::max(std::min(a, b), std::min(std::max(a, b), c));
}

}  // namespace

void median_3x3(ImageView<const std::uint8_t> in, ImageView<std::uint8_t> out) noexcept {
  PLED_CHECK(in.width == out.width && in.height == out.height);
  struct Column {
    std::uint8_t low, middle, high;
  };
  for (int y = 0; y < in.height; ++y) {
    const std::uint8_t* above = in.row(std::max(y - 1, 0));
    const std::uint8_t* here = in.row(y);
    const std::uint8_t* below = in.row(std::min(y + 1, in.height - 1));
    const auto column = [&](int x) {
      const std::uint8_t a = above[x];
      const std::uint8_t b = here[x];
      const std::uint8_t c = below[x];
      return Column{std::min({a, b, c}), median(a, b, c), std::max({a, b, c})};
    };
    std::uint8_t* to = out.row(y);
    Column left = column(0);
    Column middle = left;
    for (int x = 0; x < in.width; ++x) {
      const Column right = column(std::min(x + 1, in.width - 1));
      // The median of nine is that of the largest low, the middle one of the middles, the least
      // high.
      to[x] = median(std::max({left.low, middle.low, right.low}),
                     median(left.middle, middle.middle, right.middle),
                     std::min({left.high, middle.high, right.high}));
      left = middle;
      middle = right;
    }
  }
}

void shrink(ImageView<const std::uint8_t> in, std::span<float> row,
            ImageView<std::uint8_t> out) noexcept {
  PLED_CHECK(out.width == shrunk_px(in.width) && out.height == shrunk_px(in.height));
  PLED_CHECK(row.size() >= static_cast<std::size_t>(in.width));
  std::array<Taps, kPhases> phases;
  for (int i = 0; i < kPhases; ++i) phases[static_cast<std::size_t>(i)] = taps_of(i);
  for (int y = 0; y < out.height; ++y) {
    const Taps& down = phases[static_cast<std::size_t>(y % kPhases)];
    const int top = down.first + y / kPhases * kPeriod;
    std::fill_n(row.begin(), in.width, 0.0F);
    for (int k = 0; k < kTaps; ++k) {
      const std::uint8_t* from = in.row(std::clamp(top + k, 0, in.height - 1));
      const float w = down.weight[static_cast<std::size_t>(k)];
      for (int x = 0; x < in.width; ++x)
        row[static_cast<std::size_t>(x)] += w * static_cast<float>(from[x]);
    }
    std::uint8_t* to = out.row(y);
    for (int x = 0; x < out.width; ++x) {
      const Taps& across = phases[static_cast<std::size_t>(x % kPhases)];
      const int left = across.first + x / kPhases * kPeriod;
      std::array<float, kTaps> at_border;
      const float* from = at_border.data();
      if (left >= 0 && left + kTaps <= in.width) {
        from = row.data() + left;
      } else {
        for (int k = 0; k < kTaps; ++k)
          at_border[static_cast<std::size_t>(k)] =
              row[static_cast<std::size_t>(std::clamp(left + k, 0, in.width - 1))];
      }
      to[x] = weighted(across, from);
    }
  }
}

void sobel(ImageView<const std::uint8_t> in, ImageView<GradientPixel> out) noexcept {
  PLED_CHECK(in.width == out.width && in.height == out.height);
  for (int y = 0; y < in.height; ++y) {
    const std::uint8_t* above = in.row(std::max(y - 1, 0));
    const std::uint8_t* here = in.row(y);
    const std::uint8_t* below = in.row(std::min(y + 1, in.height - 1));
    const auto gradient = [&](int l, int x, int r) {
      const int gx = above[r] - above[l] + 2 * (here[r] - here[l]) + below[r] - below[l];
      const int gy = below[l] - above[l] + 2 * (below[x] - above[x]) + below[r] - above[r];
      return GradientPixel{static_cast<std::int16_t>(gx), static_cast<std::int16_t>(gy)};
    };
    GradientPixel* to = out.row(y);
    const int last = in.width - 1;
    to[0] = gradient(0, 0, std::min(1, last));
    for (int x = 1; x < last; ++x) to[x] = gradient(x - 1, x, x + 1);
    to[last] = gradient(std::max(last - 1, 0), last, last);
  }
}

Eigen::Vector2d gradient_at(ImageView<const GradientPixel> gradient,
                            const Eigen::Vector2d& px) noexcept {
  const int x = std::clamp(static_cast<int>(px.x()), 0, gradient.width - 2);
  const int y = std::clamp(static_cast<int>(px.y()), 0, gradient.height - 2);
  const double fx = px.x() - x;
  const double fy = px.y() - y;
  const auto value = [&](int row, int column) -> Eigen::Vector2d {
    const GradientPixel& g = gradient.at(row, column);
    return {static_cast<double>(g.x), static_cast<double>(g.y)};
  };
  return (1 - fy) * ((1 - fx) * value(y, x) + fx * value(y, x + 1)) +
         fy * ((1 - fx) * value(y + 1, x) + fx * value(y + 1, x + 1));
}

}  // namespace pled
