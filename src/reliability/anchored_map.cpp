#include "pled_vins/reliability/anchored_map.hpp"

#include <cmath>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

constexpr BinNumber kBins = limits::kTimeBins;

std::uint32_t total(const BinCounts& counts) noexcept {
  std::uint32_t n = 0;
  for (const std::uint8_t c : counts) n += c;
  return n;
}

}  // namespace

AnchoredMap::AnchoredMap(const ReliabilityConfig& config, int width_px, int height_px,
                         const AnchoredMapBuffers& buffers) noexcept
    : tables_(config.recency_alpha),
      max_shift_px_(config.anchor_shift_px),
      max_age_(Duration::from_s(config.anchor_age_ms * 1e-3)),
      grids_{BinCounters{width_px, height_px, buffers.grids[0]},
             BinCounters{width_px, height_px, buffers.grids[1]}} {
  PLED_CHECK(check(config).key == nullptr);
}

void AnchoredMap::reset() noexcept {
  for (BinCounters& grid : grids_) grid.clear();
  num_targets_ = 0;
  anchors_ = 0;
}

void AnchoredMap::begin_anchor(std::size_t slot, std::uint8_t grid,
                               Timestamp t_reference) noexcept {
  targets_[slot] = {grid, t_reference};
  num_targets_ = slot + 1;
  ++anchors_;
}

void AnchoredMap::begin_bin(BinNumber bin, Timestamp t_begin, double shift_px) noexcept {
  if (num_targets_ > 0 && bin <= newest_) return;
  const bool empty_window = num_targets_ == 0 || bin - newest_ > kBins;
  newest_ = bin;
  if (empty_window) {
    begin_anchor(0, targets_[0].grid, t_begin);
    return;
  }
  // A frame may still read the window that ends with the bin before this one.
  if (num_targets_ == 2 && bin - next_from_ >= kBins) {
    targets_[0] = targets_[1];
    num_targets_ = 1;
    return;  // shift_px was that of the anchor before
  }
  const bool worn = !(shift_px <= max_shift_px_) || t_begin - targets_[0].t_reference > max_age_;
  if (num_targets_ == 1 && worn) {
    begin_anchor(1, static_cast<std::uint8_t>(1 - targets_[0].grid), t_begin);
    next_from_ = bin;
  }
}

void AnchoredMap::add(const AnchorTarget& target, std::span<const WarpedPixel> events,
                      BinNumber bin) noexcept {
  grids_[target.grid & 1U].add(events, bin);
}

std::optional<Timestamp> AnchoredMap::reference() const noexcept {
  if (num_targets_ == 0) return std::nullopt;
  return targets_[0].t_reference;
}

BinCounts AnchoredMap::counts_at(int x_px, int y_px, BinNumber last) const noexcept {
  if (num_targets_ == 0) return {};
  return grids_[targets_[0].grid].counts_at(x_px, y_px, last);
}

std::optional<PixelScore> AnchoredMap::read(double x_px, double y_px, BinNumber last,
                                            ScorePooling pooling, ScoreForm form) const noexcept {
  constexpr double kFarthest_px = 1e6;  // beyond any sensor, within int
  if (num_targets_ == 0) return std::nullopt;
  if (!(std::abs(x_px) < kFarthest_px && std::abs(y_px) < kFarthest_px)) return std::nullopt;
  const int x = static_cast<int>(std::floor(x_px + 0.5));
  const int y = static_cast<int>(std::floor(y_px + 0.5));
  const BinCounters& grid = grids_[targets_[0].grid];
  if (!grid.contains(x, y)) return std::nullopt;

  BinCounts best = grid.counts_at(x, y, last);
  std::uint32_t most = total(best);
  PixelScore mean;
  int active = 0;
  const int reach = pooling == ScorePooling::kPixel ? 0 : 1;
  for (int yy = y - reach; yy <= y + reach; ++yy) {
    for (int xx = x - reach; xx <= x + reach; ++xx) {
      const BinCounts counts = grid.counts_at(xx, yy, last);
      const std::uint32_t n = total(counts);
      if (n == 0) continue;
      if (n > most) {
        best = counts;
        most = n;
      }
      if (pooling != ScorePooling::kMeanActive) continue;
      const PixelScore one = tables_.score(counts, form);
      ++active;
      mean = {mean.h + one.h, mean.q + one.q, mean.s + one.s, mean.n + one.n};
    }
  }
  if (most == 0) return std::nullopt;
  if (pooling != ScorePooling::kMeanActive) return tables_.score(best, form);
  return PixelScore{mean.h / active, mean.q / active, mean.s / active, mean.n};
}

BinCounterLosses AnchoredMap::losses() const noexcept {
  const BinCounterLosses& a = grids_[0].losses();
  const BinCounterLosses& b = grids_[1].losses();
  return {a.saturated + b.saturated, a.late + b.late, a.outside + b.outside};
}

}  // namespace pled
