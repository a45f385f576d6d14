#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/timestamp.hpp"
#include "pled_vins/reliability/bin_counters.hpp"
#include "pled_vins/reliability/config.hpp"
#include "pled_vins/reliability/entropy_recency.hpp"

namespace pled {

/// The memory of an AnchoredMap, whatever the grid's size.
struct AnchoredMapBuffers {
  std::array<std::span<BinCell>, 2> grids;
};

/// The same as arrays, for the grids of sensors up to MaxWidth x MaxHeight pixels: a margin of
/// limits::kMapMargin_px more on each side. Plain data, no constructor.
template <int MaxWidth, int MaxHeight>
struct AnchoredMapStorage {
  static constexpr std::size_t kCells = BinCounters::cells_needed(
      MaxWidth + 2 * limits::kMapMargin_px, MaxHeight + 2 * limits::kMapMargin_px);

  std::array<std::array<BinCell, kCells>, 2> grids;

  [[nodiscard]] AnchoredMapBuffers view() noexcept { return {{grids[0], grids[1]}}; }
};

/// An orientation that events are to be warped to: that of the camera at `t_reference`.
struct AnchorTarget {
  std::uint8_t grid = 0;  ///< 0 or 1
  Timestamp t_reference;
};

/// Which pixels around the one that was asked for speak for it.
enum class ScorePooling : std::uint8_t {
  kPixel,       ///< itself
  kMostEvents,  ///< of 3 x 3, the one with most events; itself, then the first in rows, if equal
  kMeanActive,  ///< of 3 x 3, the mean of h, q and s over those with events; n is their sum
};

/// The entropy-recency map of a camera that turns.
///
/// Counters are exact only while all events of a window are warped to one orientation. That of the
/// observation is not known when the events come, so they are warped to an anchor: the orientation
/// at some earlier time, in a grid of counters of its own. When the picture has turned by a few
/// pixels since, a second anchor begins in the other grid; for B bins both get every event; then
/// the second has a whole window of its own and takes over. No counter is ever moved, and no cell
/// cleared: what a grid held when it was left has aged out of the window by the time it is read.
///
/// Exact: what read() gives is the batch formula on the events warped to that anchor, whatever
/// anchors came before. What it differs in from warping all events of the window anew to the
/// observation's orientation is the place of the pixel grid, less than a pixel (see
/// src/reliability/README.md for how much that is).
///
/// In each bin: begin_bin(); then, for each of targets(), warp the bin's events and add() them. No
/// allocation, one thread.
class AnchoredMap {
 public:
  /// @param config  valid: check(config).key == nullptr
  /// @param width_px, height_px  of the grid, margins included; its cells fit the buffers
  AnchoredMap(const ReliabilityConfig& config, int width_px, int height_px,
              const AnchoredMapBuffers& buffers) noexcept;

  /// Begins a bin; bins without events may be left out. Changes targets(). After B bins or more
  /// without a call, the window is empty and the map starts over here at once.
  ///
  /// @param bin  newer than all before; one that is not is ignored
  /// @param t_begin  its begin: the reference time of an anchor that begins with it
  /// @param shift_px  how far the picture turned between reference() and t_begin, where it turned
  ///        most; 0 before the first anchor. NaN counts as too far.
  void begin_bin(BinNumber bin, Timestamp t_begin, double shift_px) noexcept;

  /// The orientations that the events of this bin are needed in: none before the first begin_bin(),
  /// then one, or two while an anchor takes over. First the one that read() uses.
  [[nodiscard]] std::span<const AnchorTarget> targets() const noexcept {
    return {targets_.data(), num_targets_};
  }

  /// Counts events of one bin, warped to the orientation of `target`, one of targets(). The bin is
  /// the one begun or, for late events, an older one.
  void add(const AnchorTarget& target, std::span<const WarpedPixel> events, BinNumber bin) noexcept;

  /// Reference time of the anchor that is read; nullopt before the first.
  [[nodiscard]] std::optional<Timestamp> reference() const noexcept;

  /// The counts of the window that ends with `last`, the bin begun or the one before it, at a pixel
  /// of the grid as seen from reference(). Zeros beyond it. Cost: O(1).
  [[nodiscard]] BinCounts counts_at(int x_px, int y_px, BinNumber last) const noexcept;

  /// The score of that window at the pixel nearest to a place in the grid as seen from
  /// reference(). nullopt beyond the grid, for a place that is not finite, before the
  /// first anchor, and without a single event: no evidence.
  [[nodiscard]] std::optional<PixelScore> read(double x_px, double y_px, BinNumber last,
                                               ScorePooling pooling = ScorePooling::kPixel,
                                               ScoreForm form = ScoreForm::kClean) const noexcept;

  /// Starts over, as if newly made.
  void reset() noexcept;

  /// Events lost in the grids, over all anchors. An event that two anchors lost counts twice.
  [[nodiscard]] BinCounterLosses losses() const noexcept;
  /// Anchors begun.
  [[nodiscard]] std::uint64_t anchors() const noexcept { return anchors_; }
  [[nodiscard]] const ScoreTables& tables() const noexcept { return tables_; }
  [[nodiscard]] int width_px() const noexcept { return grids_[0].width_px(); }
  [[nodiscard]] int height_px() const noexcept { return grids_[0].height_px(); }

 private:
  void begin_anchor(std::size_t slot, std::uint8_t grid, Timestamp t_reference) noexcept;

  ScoreTables tables_;
  double max_shift_px_;
  Duration max_age_;
  std::array<BinCounters, 2> grids_;
  std::array<AnchorTarget, 2> targets_{};
  std::size_t num_targets_ = 0;
  BinNumber newest_ = 0;
  BinNumber next_from_ = 0;  ///< first bin of the second anchor
  std::uint64_t anchors_ = 0;
};

}  // namespace pled
