#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"

namespace pled {

/// What was wrong with the inertial stream, counted.
struct ImuFaults {
  std::uint64_t gaps = 0;        ///< dt > max(4 x median, 25 ms)
  std::uint64_t duplicates = 0;  ///< same stamp as before: dropped
  std::uint64_t backwards = 0;   ///< stamp below the last: dropped
  std::uint64_t not_finite = 0;  ///< NaN or infinity: dropped
  std::uint64_t implausible =
      0;  ///< beyond what such a sensor can measure, or a lone spike: dropped
  std::uint64_t overwritten = 0;  ///< samples that gave way before release_before() let go of them
};

/// The last few seconds of inertial samples, strictly increasing in time, with
/// gaps known. Fixed memory; the oldest sample gives way.
class ImuHistory {
 public:
  /// Appends one sample. False when it was dropped (and counted in faults()). One that jumps from
  /// the last by more than a body does between samples is held back until the next: when that is
  /// as before the jump, it was a spike, and dropped.
  bool add(const ImuSample& sample) noexcept;
  /// Forgets samples, median and faults.
  void clear() noexcept;
  /// Forgets samples and median, for instance because another clock stamps from here on.
  void forget_samples() noexcept;
  /// Says that samples before `t` are no longer needed. They stay readable until their place is
  /// needed; giving way is then no fault.
  void release_before(Timestamp t) noexcept;
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] const ImuSample& operator[](std::size_t i) const noexcept;  ///< 0 = oldest
  [[nodiscard]] std::optional<Timestamp> newest() const noexcept;
  [[nodiscard]] std::optional<Timestamp> oldest() const noexcept;
  [[nodiscard]] const ImuFaults& faults() const noexcept { return faults_; }
  /// Median of the last 31 dt, 0 before there are 3 samples.
  [[nodiscard]] Duration median_period() const noexcept;
  [[nodiscard]] Duration gap_threshold() const noexcept;  ///< max(4 x median, 25 ms)

  /// The samples that cover [from, to]: the ends interpolated (by the cubic through
  /// the four nearest, linearly where steps are uneven) to exactly `from` and `to`,
  /// everything between as measured. An end at most gap_threshold()
  /// beyond the oldest or newest sample repeats that sample's values. Returns the number
  /// written to `out` (>= 2), or 0 when the span is not covered, `out` is too
  /// small, or to <= from. `has_gap` tells whether a gap lies inside: the samples
  /// are still given, and the caller decides. O(log size + samples written).
  [[nodiscard]] std::size_t interval(Timestamp from, Timestamp to, std::span<ImuSample> out,
                                     bool& has_gap) const noexcept;

  /// Rotation R_from_to of the body from the gyro alone: v_from = R * v_to. nullopt when not
  /// covered or when a gap lies inside.
  [[nodiscard]] std::optional<Eigen::Quaterniond> rotation(
      Timestamp from, Timestamp to, const Eigen::Vector3d& gyro_bias_radps) const noexcept;

 private:
  /// The sequence that covers a span: start, samples [first, first + count), end.
  struct Cover {
    ImuSample start;
    ImuSample end;
    std::size_t first = 0;
    std::size_t count = 0;
    bool has_gap = false;

    [[nodiscard]] std::size_t size() const noexcept { return count + 2; }
  };

  void append(const ImuSample& sample) noexcept;
  [[nodiscard]] bool cover(Timestamp from, Timestamp to, Cover& c) const noexcept;
  [[nodiscard]] const ImuSample& covered(const Cover& c, std::size_t i) const noexcept;
  /// Index of the first sample at or after t; size() when there is none.
  [[nodiscard]] std::size_t lower_bound(Timestamp t) const noexcept;
  /// Values at t, repeated beyond the ends. Needs a sample.
  [[nodiscard]] ImuSample sample_at(Timestamp t) const noexcept;

  std::array<ImuSample, limits::kImuHistory> samples_{};
  std::size_t head_ = 0;  ///< place of the oldest sample
  std::size_t size_ = 0;
  std::array<std::int64_t, 31> recent_dt_us_{};
  std::size_t dt_count_ = 0;
  std::optional<ImuSample> suspect_;  ///< newer than all, not believed yet
  Timestamp released_{std::numeric_limits<std::int64_t>::min()};
  ImuFaults faults_;
};

}  // namespace pled
