#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"

namespace pled {

/// Rotations that carry bearings from the time they were seen to one instant: constant inside
/// slices of equal length, each right in its middle.
struct TurnSlices {
  Timestamp t_ref;            ///< where all are carried to
  std::int64_t begin_us = 0;  ///< of slice 0, a multiple of the length
  int length_log2_us = 0;     ///< a slice is 2^this microseconds long
  std::size_t count = 0;
  /// bearing_ref = R bearing_slice, camera frame; row-major. The first `count` are filled.
  std::array<std::array<float, 9>, limits::kMaxTurnSlices> R_ref_slice;

  /// Begin of slice i, also for i == count.
  [[nodiscard]] std::int64_t begin_of_us(std::size_t i) const noexcept {
    return begin_us + (static_cast<std::int64_t>(i) << length_log2_us);
  }
  /// The slice that holds t; count when none does.
  [[nodiscard]] std::size_t index(std::int64_t t_us) const noexcept {
    if (t_us < begin_us) return count;
    const std::uint64_t age =
        static_cast<std::uint64_t>(t_us) - static_cast<std::uint64_t>(begin_us);
    const std::uint64_t i = age >> length_log2_us;
    return i < count ? static_cast<std::size_t>(i) : count;
  }
};

/// What was wrong with the samples given to a TurnHistory, counted.
struct TurnFaults {
  std::uint64_t gaps = 0;        ///< steps above TurnHistory::kMaxStep_us: the history begins anew
  std::uint64_t backwards = 0;   ///< stamps below the newest: dropped
  std::uint64_t restarts = 0;    ///< stamps far below the newest: the history begins anew
  std::uint64_t not_finite = 0;  ///< rates that are not finite: dropped
};

/// The orientation of the event camera over the last second, integrated from the gyro as samples
/// arrive. Only differences mean something: the first orientation is arbitrary.
///
/// What is known of an instant depends on the samples up to it, or to the first one after it, never
/// on those that come later: the knot before it has orientation, rate and acceleration, and nothing
/// else is used. So an event is carried to the same place, to the bit, whenever it comes.
///
/// Fixed memory (66 KB); no allocation, no thread.
class TurnHistory {
 public:
  static constexpr int kKnotLog2_us = 10;
  static constexpr std::int64_t kKnot_us = std::int64_t{1} << kKnotLog2_us;
  /// A longer step between samples is a gap, over which nobody knows how the camera turned.
  static constexpr std::int64_t kMaxStep_us = 25'000;
  /// A stamp so far below the newest is another clock's, and the history begins anew with it.
  static constexpr std::int64_t kOtherClock_us = 1'000'000;

  /// Integrates on from the newest sample, linearly between samples. A sample with the newest
  /// stamp is known already and passed over, so intervals that share an end may follow each other.
  /// @param[in] gyro_bias_radps  body frame, subtracted from this call's samples
  /// @param[in] R_body_cam  camera to body coordinates
  /// @returns false when a sample was dropped or the history began anew (see faults())
  bool extend(std::span<const ImuSample> samples, const Eigen::Vector3d& gyro_bias_radps,
              const Eigen::Quaterniond& R_body_cam) noexcept;
  /// Forgets the orientations; faults stay.
  void clear() noexcept;

  /// Span of time that is known; nullopt before two samples and a knot.
  [[nodiscard]] std::optional<Timestamp> oldest() const noexcept;
  [[nodiscard]] std::optional<Timestamp> newest() const noexcept;
  [[nodiscard]] const TurnFaults& faults() const noexcept { return faults_; }

  /// R_a_b: takes bearings of the camera at t_b to the camera at t_a. nullopt outside the span.
  [[nodiscard]] std::optional<Eigen::Quaterniond> rotation(Timestamp t_a,
                                                           Timestamp t_b) const noexcept;

  /// Slices over [t_from, t_to] that carry to t_ref. Their length, 64 us to 1.024 ms, is the
  /// longest whose rotation differs from the exact one by at most `max_error_rad` anywhere in the
  /// span. Boundaries are multiples of the length on the clock, so no slice reaches over a knot (a
  /// multiple of kKnot_us), and slices of a span between two knots depend on nothing else in it:
  /// what should not depend on how events are split into spans is to be split at the knots.
  /// @returns false, with `out` untouched, unless oldest() <= t_from <= t_to <= newest() and t_ref
  ///          is in the span as well.
  /// Cost: about 60 ns a slice.
  [[nodiscard]] bool slices(Timestamp t_ref, Timestamp t_from, Timestamp t_to, double max_error_rad,
                            TurnSlices& out) const noexcept;

 private:
  /// What is known at a knot, in the camera's frame. The rate goes on linearly from there.
  struct Knot {
    Eigen::Quaterniond R_start_knot;
    Eigen::Vector3f rate_radps;
    Eigen::Vector3f accel_radps2;
  };

  void begin(const ImuSample& sample, const Eigen::Vector3d& gyro_bias_radps,
             const Eigen::Quaterniond& R_cam_body) noexcept;
  void integrate_to(const ImuSample& sample, const Eigen::Vector3d& gyro_bias_radps,
                    const Eigen::Quaterniond& R_cam_body) noexcept;
  /// At the tip. Both are of the camera in its frame.
  void add_knot(const Eigen::Vector3d& rate_radps, const Eigen::Vector3d& accel_radps2) noexcept;
  [[nodiscard]] bool covers(Timestamp t) const noexcept;
  [[nodiscard]] const Knot& knot(std::int64_t number) const noexcept;
  /// R_start_t at a covered time, or before the knot that follows one.
  [[nodiscard]] Eigen::Quaterniond at(std::int64_t t_us) const noexcept;
  /// No less than the fastest turn in the span.
  [[nodiscard]] double max_rate_radps(std::int64_t from_us, std::int64_t to_us) const noexcept;

  std::array<Knot, limits::kTurnKnots> knots_;  ///< knot n, at n kKnot_us, is n mod size
  std::int64_t newest_knot_ = 0;
  std::size_t num_knots_ = 0;
  bool has_sample_ = false;
  std::int64_t tip_us_ = 0;  ///< the newest sample's stamp
  Eigen::Quaterniond R_start_tip_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d tip_gyro_radps_ = Eigen::Vector3d::Zero();  ///< as measured, body frame
  TurnFaults faults_;
};

}  // namespace pled
