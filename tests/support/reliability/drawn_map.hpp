#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "pled_vins/reliability/anchored_map.hpp"
#include "support/reliability/score_by_definition.hpp"

namespace pled::support {

/// An entropy-recency map whose counts are drawn by hand.
class DrawnMap {
 public:
  DrawnMap(int width_px, int height_px) : width_(width_px), height_(height_px) {}

  /// c_k of a pixel, oldest first.
  void draw(int x_px, int y_px, const SlowCounts& counts) { counts_[{x_px, y_px}] = counts; }
  [[nodiscard]] SlowCounts at(int x_px, int y_px) const {
    const auto found = counts_.find({x_px, y_px});
    return found == counts_.end() ? SlowCounts{} : found->second;
  }

  /// The map with what has been drawn so far; read it up to kLast.
  const AnchoredMap& map() {
    map_.reset();
    for (std::size_t k = 0; k < kB; ++k) {
      const auto bin = static_cast<BinNumber>(k);
      map_.begin_bin(bin, Timestamp{bin * 4096}, 0.0);
      for (const auto& [place, counts] : counts_) {
        const WarpedPixel at{static_cast<std::int16_t>(place.first),
                             static_cast<std::int16_t>(place.second)};
        for (int i = 0; i < counts[k]; ++i) map_.add(map_.targets()[0], {&at, 1}, bin);
      }
    }
    return map_;
  }
  static constexpr BinNumber kLast = static_cast<BinNumber>(kB) - 1;

  [[nodiscard]] int width_px() const { return width_; }
  [[nodiscard]] int height_px() const { return height_; }

 private:
  int width_;
  int height_;
  std::map<std::pair<int, int>, SlowCounts> counts_;
  std::vector<BinCell> a_ = std::vector<BinCell>(BinCounters::cells_needed(width_, height_));
  std::vector<BinCell> b_ = a_;
  AnchoredMap map_{ReliabilityConfig{}, width_, height_, {{a_, b_}}};
};

/// A band summed pixel by pixel as eqs. (6) and (7) are printed, W = 5 and sigma = W / 4.
struct BandByDefinition {
  double s = 0.0;
  double count_reliability = 0.0;
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  int pixels = 0;
  int with_events = 0;
};

inline BandByDefinition band_by_definition(const DrawnMap& drawn, const Eigen::Vector2d& p0,
                                           const Eigen::Vector2d& p1, bool paper) {
  const double epsilon = paper ? 1e-9 : 0.0;
  const auto has = [&](int x, int y) {
    const SlowCounts c = drawn.at(x, y);
    return std::any_of(c.begin(), c.end(), [](int n) { return n > 0; });
  };
  const auto q = [&](int x, int y) { return score_by_definition(drawn.at(x, y), 2.0, epsilon).q; };
  const double L = (p1 - p0).norm();
  const Eigen::Vector2d v = (p1 - p0) / L;
  const Eigen::Vector2d n(-v.y(), v.x());
  BandByDefinition out;
  double weights = 0.0;
  int along_x = 0, along_y = 0;
  for (int y = 0; y < drawn.height_px(); ++y)
    for (int x = 0; x < drawn.width_px(); ++x) {
      const Eigen::Vector2d from_start = Eigen::Vector2d(x, y) - p0;
      const double lambda = v.dot(from_start) / L;
      const double delta = n.dot(from_start);
      if (lambda < 0 || lambda > 1 || std::abs(delta) > 2.5) continue;
      if (!paper && !has(x, y)) continue;
      const double w = std::exp(-delta * delta / (2 * 1.25 * 1.25));
      const PixelScore score = score_by_definition(drawn.at(x, y), 2.0, epsilon);
      weights += w;
      out.s += w * score.s;
      out.count_reliability += w * 8.0 / (8.0 + score.n);
      ++out.pixels;
      out.with_events += has(x, y) ? 1 : 0;
      if (paper || (has(x - 1, y) && has(x + 1, y))) {
        out.gradient.x() += (q(x + 1, y) - q(x - 1, y)) / 2;
        ++along_x;
      }
      if (paper || (has(x, y - 1) && has(x, y + 1))) {
        out.gradient.y() += (q(x, y + 1) - q(x, y - 1)) / 2;
        ++along_y;
      }
    }
  out.s /= weights;
  out.count_reliability /= weights;
  if (along_x > 0) out.gradient.x() /= along_x;
  if (along_y > 0) out.gradient.y() /= along_y;
  return out;
}

}  // namespace pled::support
