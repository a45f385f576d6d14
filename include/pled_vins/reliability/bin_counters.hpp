#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "pled_vins/core/limits.hpp"
#include "pled_vins/geometry/warped_pixel.hpp"

namespace pled {

/// Time bins are numbered one after the other, see BinClock.
using BinNumber = std::int64_t;

/// c_k of eqs. (2) and (3): events of one pixel in each bin of the window, oldest first.
using BinCounts = std::array<std::uint8_t, limits::kTimeBins>;

/// The counters of one pixel: eight bytes of counts and the low 16 bits of the number of the newest
/// bin among them. Its content is BinCounters' business; ten bytes without alignment, because a
/// padded cell saves no instruction and costs 60 % more memory.
struct BinCell {
  std::array<std::uint8_t, limits::kTimeBins + 2> bytes;
};
static_assert(sizeof(BinCell) == 10 && alignof(BinCell) == 1);

/// What was not counted, since the last clear().
struct BinCounterLosses {
  std::uint64_t saturated = 0;  ///< events beyond the 255th in one bin of one pixel
  std::uint64_t late = 0;       ///< events at least B bins older than the newest bin
  std::uint64_t outside = 0;    ///< events beyond the grid, kOutsideGrid among them
};

/// How many events each pixel had in each of the last B time bins, in constant time per event,
/// whatever its history and the size of the grid.
///
/// A pixel ages when it is touched: its eight counts are the bytes of one integer, and passing on
/// by d bins is a shift by d bytes. Pixels that are never touched are visited by a sweep, a few
/// rows per bin, long before their 16-bit stamp could be mistaken for a new one.
///
/// The result depends on the sequence of (pixel, bin) alone, not on how it was split into calls.
/// No allocation; the memory is the caller's and outlives the counters. One thread.
class BinCounters {
 public:
  [[nodiscard]] static constexpr std::size_t cells_needed(int width_px, int height_px) noexcept {
    return static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  }

  /// @param width_px, height_px  of the grid, margins included
  /// @param cells  at least cells_needed(); what is in them does not matter
  BinCounters(int width_px, int height_px, std::span<BinCell> cells) noexcept;

  /// As if newly made.
  void clear() noexcept;

  /// Says that time has come to `bin`, whether or not there are events. An older one than the
  /// newest is ignored. Cost: width pixels for each 2^14 / height bins passed; the first time, and
  /// after 2^14 bins (67 s) at once, every cell.
  void advance_to(BinNumber bin) noexcept;

  /// Counts events of one bin. A newer bin than the newest becomes it; an older one within the
  /// last B is counted where it belongs; events that are older still, outside the grid, or too
  /// many for their counter are not counted, see losses(). Cost: O(1) each.
  void add(std::span<const WarpedPixel> events, BinNumber bin) noexcept;

  /// Counts of the B bins that end with `last`, oldest first; zeros outside the grid. Exact when
  /// the pixel has no event in a bin newer than `last`; a pixel that has one e bins newer has let
  /// the e oldest of these B bins go, and they read 0. Cost: O(1).
  [[nodiscard]] BinCounts counts_at(int x_px, int y_px, BinNumber last) const noexcept;

  /// True for pixels of the grid.
  [[nodiscard]] bool contains(int x_px, int y_px) const noexcept;

  /// The newest bin so far.
  [[nodiscard]] BinNumber newest() const noexcept { return newest_; }
  [[nodiscard]] const BinCounterLosses& losses() const noexcept { return losses_; }
  [[nodiscard]] int width_px() const noexcept { return static_cast<int>(columns_); }
  [[nodiscard]] int height_px() const noexcept { return static_cast<int>(rows_); }

 private:
  void add_newest(std::span<const WarpedPixel> events) noexcept;
  void add_late(std::span<const WarpedPixel> events, BinNumber bin) noexcept;
  void sweep(BinNumber passed) noexcept;
  [[nodiscard]] std::size_t index(int x_px, int y_px) const noexcept;

  std::span<BinCell> cells_;  ///< row-major
  std::uint32_t columns_;
  std::uint32_t rows_;
  BinNumber newest_ = 0;
  std::uint32_t sweep_row_ = 0;       ///< the next to be visited
  std::uint32_t sweep_progress_ = 0;  ///< towards that visit; due at kSweepBins
  BinCounterLosses losses_;
};

}  // namespace pled
