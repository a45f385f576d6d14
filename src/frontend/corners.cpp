#include "pled_vins/frontend/corners.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/core/hal/intrin.hpp>

#include "pled_vins/core/check.hpp"
#include "pled_vins/frontend/pyramid.hpp"

namespace pled {
namespace {

constexpr int kWindow = 2 * kCornerWindowRadius + 1;
constexpr int kTilesX = 6;
constexpr int kTilesY = 4;

/// Products of the gradient, summed along x over the window, for one row.
struct TensorRow {
  float* xx;
  float* xy;
  float* yy;
};

/// The products of one row, not yet summed.
void gradient_products(const ImageView<const std::int16_t>& level, int y,
                       const TensorRow& out) noexcept {
  const std::int16_t* above = level.row(y - 1);
  const std::int16_t* here = level.row(y);
  const std::int16_t* below = level.row(y + 1);
  for (int x = 0; x < level.width; ++x) {
    const float gx = static_cast<float>(here[x + 1] - here[x - 1]);
    const float gy = static_cast<float>(below[x] - above[x]);
    out.xx[x] = gx * gx;
    out.xy[x] = gx * gy;
    out.yy[x] = gy * gy;
  }
}

void sum_along_x(const float* in, int width, float* out) noexcept {
  for (int x = kCornerWindowRadius; x < width - kCornerWindowRadius; ++x)
    out[x] = in[x - 2] + in[x - 1] + in[x] + in[x + 1] + in[x + 2];
}
static_assert(kCornerWindowRadius == 2, "sum_along_x is written out for five values");

/// lambda_min = (a + c)/2 - sqrt(((a - c)/2)^2 + b^2) for columns [x0, x1).
void smaller_eigenvalues(const std::array<TensorRow, kWindow>& rows, int x0, int x1,
                         float* out) noexcept {
  // Central difference (1/2) of values that are grey x kPyramidScale, mean over the window.
  constexpr float kUnit =
      1.0F / (4.0F * kPyramidScale * kPyramidScale * static_cast<float>(kWindow * kWindow));
  const cv::v_float32x4 unit = cv::v_setall_f32(kUnit);
  const cv::v_float32x4 half = cv::v_setall_f32(0.5F);
  const cv::v_float32x4 zero = cv::v_setzero_f32();
  for (int x = x0; x < x1; x += 4) {
    cv::v_float32x4 a = cv::v_load(rows[0].xx + x);
    cv::v_float32x4 b = cv::v_load(rows[0].xy + x);
    cv::v_float32x4 c = cv::v_load(rows[0].yy + x);
    for (std::size_t k = 1; k < kWindow; ++k) {
      a += cv::v_load(rows[k].xx + x);
      b += cv::v_load(rows[k].xy + x);
      c += cv::v_load(rows[k].yy + x);
    }
    const cv::v_float32x4 mean = (a + c) * half;
    const cv::v_float32x4 diff = (a - c) * half;
    const cv::v_float32x4 low = mean - cv::v_sqrt(diff * diff + b * b);
    cv::v_store(out + x, cv::v_max(low * unit, zero));
  }
}

struct Tiling {
  int width_px;
  int height_px;
  [[nodiscard]] std::size_t of(const Corner& c) const noexcept {
    const int tx = std::min(c.x_px * kTilesX / width_px, kTilesX - 1);
    const int ty = std::min(c.y_px * kTilesY / height_px, kTilesY - 1);
    return static_cast<std::size_t>(std::max(ty, 0) * kTilesX + std::max(tx, 0));
  }
};

[[nodiscard]] bool is_peak(const ImageView<const float>& r, int y, int x, float v) noexcept {
  const float* above = r.row(y - 1) + x;
  const float* here = r.row(y) + x;
  const float* below = r.row(y + 1) + x;
  // Of equal neighbours the first in reading order is the peak.
  return v > above[-1] && v > above[0] && v > above[1] && v > here[-1] && v >= here[1] &&
         v >= below[-1] && v >= below[0] && v >= below[1];
}

/// The best free peak of each cell, packed to the front of `cells`.
std::size_t best_of_cells(const ImageView<const float>& response,
                          const ImageView<const std::uint8_t>& mask, const CornerDemand& demand,
                          std::span<Corner> cells) noexcept {
  int side = std::max(3, static_cast<int>(demand.min_distance_px * 0.7071F));
  const auto count = [&](int extent) { return (extent + side - 1) / side; };
  while (static_cast<std::size_t>(count(response.width) * count(response.height)) >
         std::min(cells.size(), kMaxCornerCells))
    ++side;
  const int columns = count(response.width);
  const auto num_cells = static_cast<std::size_t>(columns * count(response.height));
  std::fill_n(cells.begin(), num_cells, Corner{});
  for (int y = kCornerBorderPx; y < response.height - kCornerBorderPx; ++y) {
    const float* row = response.row(y);
    for (int x = kCornerBorderPx; x < response.width - kCornerBorderPx; ++x) {
      const float v = row[x];
      if (!(v > demand.min_score) || mask.at(y, x) != 0 || !is_peak(response, y, x, v)) continue;
      Corner& best = cells[static_cast<std::size_t>(y / side * columns + x / side)];
      if (v > best.score) best = {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), v};
    }
  }
  const auto end =
      std::remove_if(cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(num_cells),
                     [](const Corner& c) { return !(c.score > 0.0F); });
  return static_cast<std::size_t>(end - cells.begin());
}

}  // namespace

void corner_response(ImageView<const std::int16_t> level, std::span<float> scratch,
                     ImageView<float> out) noexcept {
  const int w = level.width;
  const auto width = static_cast<std::size_t>(w);
  PLED_CHECK(out.width == w && out.height == level.height);
  PLED_CHECK(scratch.size() >= kCornerScratchRows * width);
  const auto rows_at = [&](std::size_t i) {
    float* first = scratch.data() + 3 * i * width;
    return TensorRow{first, first + width, first + 2 * width};
  };
  for (int y = 0; y < out.height; ++y) std::fill_n(out.row(y), width, 0.0F);
  if (w <= 2 * kCornerBorderPx + 4 || level.height <= 2 * kCornerBorderPx) return;

  const TensorRow products = rows_at(0);
  std::array<TensorRow, kWindow> ring{};
  const int first = kCornerBorderPx - kCornerWindowRadius;
  for (int y = first; y < level.height - first; ++y) {
    const TensorRow sums = rows_at(1 + static_cast<std::size_t>(y % kWindow));
    gradient_products(level, y, products);
    sum_along_x(products.xx, w, sums.xx);
    sum_along_x(products.xy, w, sums.xy);
    sum_along_x(products.yy, w, sums.yy);
    std::rotate(ring.begin(), ring.begin() + 1, ring.end());
    ring.back() = sums;
    const int centre = y - kCornerWindowRadius;
    if (centre < kCornerBorderPx) continue;
    // Groups of four end at the last pixel, so the last group may overlap its neighbour.
    const int last = w - kCornerBorderPx;
    const int whole = kCornerBorderPx + (last - kCornerBorderPx) / 4 * 4;
    smaller_eigenvalues(ring, kCornerBorderPx, whole, out.row(centre));
    if (whole < last) smaller_eigenvalues(ring, last - 4, last, out.row(centre));
  }
}

void paint_disc(ImageView<std::uint8_t> mask, float x_px, float y_px, float radius_px) noexcept {
  const int y0 = std::max(0, static_cast<int>(std::ceil(y_px - radius_px)));
  const int y1 = std::min(mask.height - 1, static_cast<int>(std::floor(y_px + radius_px)));
  for (int y = y0; y <= y1; ++y) {
    const float dy = static_cast<float>(y) - y_px;
    const float half = std::sqrt(std::max(0.0F, radius_px * radius_px - dy * dy));
    const int x0 = std::max(0, static_cast<int>(std::ceil(x_px - half)));
    const int x1 = std::min(mask.width - 1, static_cast<int>(std::floor(x_px + half)));
    if (x0 <= x1) std::fill(mask.row(y) + x0, mask.row(y) + x1 + 1, std::uint8_t{1});
  }
}

void select_corners(ImageView<const float> response, ImageView<const std::uint8_t> mask,
                    std::span<const Corner> occupied, const CornerDemand& demand,
                    std::span<Corner> cells,
                    FixedVector<Corner, limits::kMaxPoints>& out) noexcept {
  out.clear();
  const std::size_t num = best_of_cells(response, mask, demand, cells);
  const auto found = cells.first(num);
  std::sort(found.begin(), found.end(), [](const Corner& a, const Corner& b) {
    if (a.score != b.score) return a.score > b.score;
    return a.y_px != b.y_px ? a.y_px < b.y_px : a.x_px < b.x_px;
  });
  const Tiling tiling{response.width, response.height};
  std::array<std::size_t, kTilesX * kTilesY> taken{};
  for (const Corner& c : occupied) ++taken[tiling.of(c)];

  // Ours: a tile may hold its even share and half as much again before the rest had its turn.
  const std::size_t share = std::max<std::size_t>(1, demand.total_points * 3 / (2 * taken.size()));
  const float min_square = demand.min_distance_px * demand.min_distance_px;
  for (const std::size_t quota : {share, kMaxCornerCells}) {
    for (Corner& c : found) {
      if (out.size() >= demand.count) return;
      if (!(c.score > 0.0F) || taken[tiling.of(c)] >= quota) continue;
      const bool crowded = std::any_of(out.begin(), out.end(), [&](const Corner& o) {
        const auto dx = static_cast<float>(o.x_px - c.x_px);
        const auto dy = static_cast<float>(o.y_px - c.y_px);
        return dx * dx + dy * dy < min_square;
      });
      if (!crowded && out.push_back(c)) ++taken[tiling.of(c)];
      c.score = crowded || quota == share ? 0.0F : c.score;  // decided: not seen again
    }
  }
}

}  // namespace pled
