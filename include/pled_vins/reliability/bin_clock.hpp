#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "pled_vins/core/timestamp.hpp"
#include "pled_vins/reliability/bin_counters.hpp"

namespace pled {

/// A time bin: the instants after `begin` up to and including `end`. Event and frame of the same
/// microsecond fall on the same side: the event is in the frame's window.
struct TimeBin {
  BinNumber number = 0;
  Timestamp begin;
  Timestamp end;
};

/// Numbers the time bins, and makes them end when frames are taken, because the paper's window ends
/// at the observation.
///
/// Bins follow each other without a gap. Between two frames, P apart, with bins of w:
///   P >= B w  The first bin after a frame is short (P mod w, if that is not 0), the rest are w.
///   The
///             short one is older than the window when the next frame comes: the window is exactly
///             the B w before the frame.
///   P <  B w  All bins are P / k with k = P / w rounded, at least 1 (the first up to k - 1 us
///             longer). Each is within 1 / (2k) of w, for P >= w / 2; the window is B of them, so
///             it ends at the frame and differs from B w by at most B w / (2k). Frames that come
///             faster than that shorten the window to B P.
/// P is told by expect_frame(), or guessed: the time since the frame before. When the guess was
/// wrong, on_frame() finds a frame that is not at the end of a bin, and
///   at most a quarter of a bin after one began: the window is the one that ended there, so it ends
///             up to w / 4 before the frame. Jitter opens no nearly empty bin.
///   else      the bin that has begun ends at the frame. It is between a quarter of a bin and a
///             whole bin long; all other bins of the window are as planned, so its far end is up to
///             3/4 w late. Where the frame came more than B w early, the short bin is in it too.
///
/// Numbers never go back in time: t1 <= t2 have bin_of(t1).number <= bin_of(t2).number. Times
/// before the last 16 plans get numbers by bins of w; all are beyond the window by then.
class BinClock {
 public:
  /// @param width  w > 0
  explicit BinClock(Duration width) noexcept;

  /// The bin of an instant. Cost: O(1) since the last frame, a few steps for older times.
  [[nodiscard]] TimeBin bin_of(Timestamp t) const noexcept;

  /// Lays the bins so that one ends at `t_frame`, when that is known before the events up to it are
  /// put into bins: then nothing is guessed. `t_binned` is the time up to which they have been; a
  /// bin that has begun by then keeps its number and its begin. False, and nothing changes, unless
  /// t_frame > t_binned and t_binned is not before the last frame.
  bool expect_frame(Timestamp t_frame, Timestamp t_binned) noexcept;

  /// The newest bin of the window of a frame, whose events have all been put into bins while later
  /// ones have not; lays the bins up to the next frame as guessed. A frame that is not after
  /// the last one, or not after the `t_binned` of an expected one, gets the bin that its time falls
  /// in, and changes nothing.
  BinNumber on_frame(Timestamp t_frame) noexcept;

  [[nodiscard]] Duration width() const noexcept { return {width_us_}; }

 private:
  /// Bins from an instant on: one of its own length, then equal ones without end.
  struct Plan {
    std::int64_t begin_us = 0;
    BinNumber first = 0;
    std::int64_t first_length_us = 0;
    std::int64_t length_us = 0;
  };
  static constexpr std::size_t kPlans = 16;

  [[nodiscard]] static TimeBin bin_in(const Plan& plan, std::int64_t t_us) noexcept;
  /// Bins from `begin_us` on, the first at least `min_first_us` long, one ending at `target_us`.
  void lay(std::int64_t begin_us, BinNumber first, std::int64_t min_first_us,
           std::optional<std::int64_t> target_us) noexcept;
  [[nodiscard]] const Plan& plan(std::size_t age) const noexcept;

  std::int64_t width_us_;
  std::array<Plan, kPlans> plans_{};
  std::size_t newest_ = 0;  ///< index of the plan in force
  std::size_t num_plans_ = 1;
  std::optional<Timestamp> t_frame_;  ///< last frame
};

}  // namespace pled
