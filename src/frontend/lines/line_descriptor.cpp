#include "pled_vins/frontend/lines/line_descriptor.hpp"

#include <algorithm>
#include <cmath>

namespace pled {
namespace {

constexpr std::size_t kRows = kLineBands * kBandRows;
constexpr double kMiddleRow = 31.0;
/// Spread over all rows, and over a band with its neighbours: integer halves in the original.
constexpr double kGlobalSigma = 31.0;
constexpr double kLocalSigma = 7.0;
constexpr double kLocalMiddle = 10.0;
constexpr double kCutOff = 0.4;

struct BandPair {
  std::size_t first, second;
};

constexpr std::array<BandPair, 32> kPairs{
    {{0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}, {0, 6}, {1, 2}, {1, 3}, {1, 4}, {1, 5}, {1, 6},
     {2, 3}, {2, 4}, {2, 5}, {2, 6}, {2, 7}, {2, 8}, {3, 4}, {3, 5}, {3, 6}, {3, 7}, {3, 8},
     {4, 5}, {4, 6}, {4, 7}, {4, 8}, {5, 6}, {5, 7}, {5, 8}, {6, 7}, {6, 8}, {7, 8}}};

/// Sums over a row of the positive and negative parts of the gradient along and across the line.
using RowSums = std::array<double, 4>;

/// Weighted sums of a band's rows.
struct BandSums {
  RowSums plain{};
  RowSums squared{};
};

double gauss(double offset, double sigma) noexcept {
  return std::exp(-offset * offset / (2.0 * sigma * sigma));
}

/// What rows count: over all of them, and within a band and its two neighbours.
struct RowWeights {
  std::array<double, kRows> global{};
  std::array<double, 3 * kBandRows> local{};

  RowWeights() noexcept {
    for (std::size_t k = 0; k < global.size(); ++k)
      global[k] = gauss(static_cast<double>(k) - kMiddleRow, kGlobalSigma);
    for (std::size_t j = 0; j < local.size(); ++j)
      local[j] = gauss(static_cast<double>(j) - kLocalMiddle, kLocalSigma);
  }
};
const RowWeights kWeights;

bool inside(const ImageView<const GradientPixel>& image, const Eigen::Vector2d& px) noexcept {
  return px.x() >= 0.0 && px.y() >= 0.0 && px.x() <= image.width - 1 && px.y() <= image.height - 1;
}

/// Two pixels at a time, one in each lane.
/// @param kClamp  whether pixels may lie outside the picture
template <bool kClamp>
RowSums sum_row(const ImageView<const GradientPixel>& gradient, const Eigen::Vector2d& first,
                const Eigen::Vector2d& step, int count, const Eigen::Vector2d& along) noexcept {
  using Lanes = Eigen::Array2d;
  const auto pixel = [&](double x, double y) -> const GradientPixel& {
    return gradient.at(static_cast<int>(y), static_cast<int>(x));
  };
  Lanes along_rises = Lanes::Zero(), along_falls = Lanes::Zero();
  Lanes across_rises = Lanes::Zero(), across_falls = Lanes::Zero();
  Lanes place(0.0, 1.0);
  for (int i = 0; i < count; i += 2, place += 2.0) {
    Lanes x = first.x() + place * step.x();
    Lanes y = first.y() + place * step.y();
    if constexpr (kClamp) {
      x = x.max(0.0).min(static_cast<double>(gradient.width - 1));
      y = y.max(0.0).min(static_cast<double>(gradient.height - 1));
    }
    x += 0.5;
    y += 0.5;
    const GradientPixel a = pixel(x[0], y[0]);
    const GradientPixel b = i + 1 < count ? pixel(x[1], y[1]) : GradientPixel{};
    const Lanes gx(a.x, b.x), gy(a.y, b.y);
    const Lanes by_along = gx * along.x() + gy * along.y();
    const Lanes by_across = gy * along.x() - gx * along.y();  // across is (-along_y, along_x)
    along_rises += by_along.max(0.0);
    along_falls -= by_along.min(0.0);
    across_rises += by_across.max(0.0);
    across_falls -= by_across.min(0.0);
  }
  return {along_rises.sum(), along_falls.sum(), across_rises.sum(), across_falls.sum()};
}

void add_row(const RowSums& row, double weight, BandSums& band) noexcept {
  for (std::size_t v = 0; v < row.size(); ++v) {
    const double value = weight * row[v];
    band.plain[v] += value;
    band.squared[v] += value * value;
  }
}

/// Values v of every band in [from, from + 4) to unit length together; nothing if all are 0.
void normalise(LineBands& bands, std::size_t from, std::size_t count) noexcept {
  double square = 0.0;
  for (std::size_t b = 0; b < kLineBands; ++b)
    for (std::size_t v = from; v < from + count; ++v)
      square += bands[b * kBandValues + v] * bands[b * kBandValues + v];
  if (!(square > 0.0)) return;
  const double unit = 1.0 / std::sqrt(square);
  for (std::size_t b = 0; b < kLineBands; ++b)
    for (std::size_t v = from; v < from + count; ++v) bands[b * kBandValues + v] *= unit;
}

LineBands means_and_deviations(const std::array<BandSums, kLineBands>& sums) noexcept {
  LineBands bands{};
  for (std::size_t b = 0; b < kLineBands; ++b) {
    const bool outermost = b == 0 || b + 1 == kLineBands;
    const double rows = static_cast<double>((outermost ? 2 : 3) * kBandRows);
    for (std::size_t v = 0; v < 4; ++v) {
      const double mean = sums[b].plain[v] / rows;
      const double variance = sums[b].squared[v] / rows - mean * mean;
      bands[b * kBandValues + v] = mean;
      bands[b * kBandValues + 4 + v] = std::sqrt(std::max(variance, 0.0));
    }
  }
  return bands;
}

}  // namespace

LineBands line_bands(ImageView<const GradientPixel> gradient, const Eigen::Vector2d& start_px,
                     const Eigen::Vector2d& end_px) noexcept {
  const Eigen::Vector2d line = end_px - start_px;
  const double length = line.norm();
  if (!(length > 0.0)) return {};
  const Eigen::Vector2d along = line / length;
  const Eigen::Vector2d across(-along.y(), along.x());
  const int count =
      static_cast<int>(std::clamp(length + 0.5, 1.0, static_cast<double>(kMaxRowPixels)));
  const double spacing = length > kMaxRowPixels ? length / kMaxRowPixels : 1.0;
  const Eigen::Vector2d step = spacing * along;
  const Eigen::Vector2d middle_start = 0.5 * (start_px + end_px) - 0.5 * (count - 1) * step;

  std::array<BandSums, kLineBands> sums{};
  for (std::size_t k = 0; k < kRows; ++k) {
    const double offset = static_cast<double>(k) - kMiddleRow;
    const Eigen::Vector2d first = middle_start + offset * across;
    const bool whole = inside(gradient, first) && inside(gradient, first + (count - 1) * step);
    RowSums row = whole ? sum_row<false>(gradient, first, step, count, along)
                        : sum_row<true>(gradient, first, step, count, along);
    for (double& v : row) v *= kWeights.global[k];
    // Row m of a band is row m + 7 of that band with its neighbours, m + 14 of the band before,
    // m of the band after.
    const std::size_t band = k / kBandRows;
    const std::size_t m = k % kBandRows;
    add_row(row, kWeights.local[m + kBandRows], sums[band]);
    if (band > 0) add_row(row, kWeights.local[m + 2 * kBandRows], sums[band - 1]);
    if (band + 1 < kLineBands) add_row(row, kWeights.local[m], sums[band + 1]);
  }
  LineBands bands = means_and_deviations(sums);
  normalise(bands, 0, 4);
  normalise(bands, 4, 4);
  for (double& v : bands) v = std::min(v, kCutOff);
  normalise(bands, 0, kBandValues);
  return bands;
}

LineDescriptor compare_bands(const LineBands& bands) noexcept {
  LineDescriptor out;
  for (std::size_t p = 0; p < kPairs.size(); ++p)
    for (std::size_t v = 0; v < kBandValues; ++v) {
      const std::size_t bit = kBandValues * p + v;
      const double first = bands[kPairs[p].first * kBandValues + v];
      const double second = bands[kPairs[p].second * kBandValues + v];
      if (first > second) out.bits[bit / 64] |= std::uint64_t{1} << (bit % 64);
    }
  return out;
}

}  // namespace pled
