#include "pled_vins/events/turn_history.hpp"

#include <algorithm>
#include <cmath>

#include "pled_vins/core/check.hpp"
#include "pled_vins/geometry/so3.hpp"

namespace pled {
namespace {

constexpr int kMinSliceLog2_us = 6;   // 64 us: a fast sensor's time resolution
constexpr int kMaxSliceLog2_us = 13;  // 8.2 ms: still many to a time surface

/// Between neighbouring knots, which are at most some hundredths of a radian apart, where the
/// straight line between quaternions differs from the arc by less than 1e-6 rad.
Eigen::Quaterniond between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b,
                           double s) noexcept {
  const Eigen::Vector4d mixed = (1.0 - s) * a.coeffs() + s * b.coeffs();
  return Eigen::Quaterniond(mixed).normalized();
}

}  // namespace

bool TurnHistory::extend(std::span<const ImuSample> samples, const Eigen::Vector3d& gyro_bias_radps,
                         const Eigen::Quaterniond& R_body_cam) noexcept {
  const Eigen::Quaterniond R_cam_body = R_body_cam.conjugate();
  bool sound = true;
  for (const ImuSample& sample : samples) {
    const Eigen::Map<const Eigen::Vector3d> gyro(sample.gyro_radps.data());
    if (!gyro.allFinite()) {
      ++faults_.not_finite;
      sound = false;
      continue;
    }
    if (!has_sample_) {
      begin(sample);
      continue;
    }
    const std::int64_t step_us = sample.t.us - tip_us_;
    if (step_us == 0) continue;
    if (step_us > 0 && step_us <= kMaxStep_us) {
      integrate_to(sample, gyro_bias_radps, R_cam_body);
      continue;
    }
    sound = false;
    if (step_us < 0 && step_us > -kOtherClock_us) {
      ++faults_.backwards;
      continue;
    }
    ++(step_us > 0 ? faults_.gaps : faults_.restarts);
    clear();
    begin(sample);
  }
  return sound;
}

void TurnHistory::clear() noexcept {
  has_sample_ = false;
  num_knots_ = 0;
}

void TurnHistory::begin(const ImuSample& sample) noexcept {
  has_sample_ = true;
  tip_us_ = sample.t.us;
  R_start_tip_.setIdentity();
  tip_gyro_radps_ = Eigen::Map<const Eigen::Vector3d>(sample.gyro_radps.data());
  newest_knot_ = (tip_us_ - 1) >> kKnotLog2_us;
  if (tip_us_ == (newest_knot_ + 1) * kKnot_us) add_knot();
}

void TurnHistory::add_knot() noexcept {
  ++newest_knot_;
  num_knots_ = std::min(num_knots_ + 1, limits::kTurnKnots);
  knots_[static_cast<std::uint64_t>(newest_knot_) % limits::kTurnKnots] = R_start_tip_;
}

void TurnHistory::integrate_to(const ImuSample& sample, const Eigen::Vector3d& gyro_bias_radps,
                               const Eigen::Quaterniond& R_cam_body) noexcept {
  const std::int64_t from_us = tip_us_;
  const Eigen::Vector3d gyro_from = tip_gyro_radps_;
  const Eigen::Vector3d gyro_to = Eigen::Map<const Eigen::Vector3d>(sample.gyro_radps.data());
  const auto step_us = static_cast<double>(sample.t.us - from_us);
  while (tip_us_ < sample.t.us) {
    const std::int64_t next_knot_us = (newest_knot_ + 1) * kKnot_us;
    const std::int64_t to_us = std::min(next_knot_us, sample.t.us);
    // The rate is linear between samples, so its mean over a part is that in the part's middle.
    const double middle =
        0.5 * static_cast<double>((tip_us_ - from_us) + (to_us - from_us)) / step_us;
    const Eigen::Vector3d rate = gyro_from + middle * (gyro_to - gyro_from) - gyro_bias_radps;
    const double dt_s = static_cast<double>(to_us - tip_us_) * 1e-6;
    R_start_tip_ = (R_start_tip_ * so3::exp(R_cam_body * (rate * dt_s))).normalized();
    tip_us_ = to_us;
    if (to_us == next_knot_us) add_knot();
  }
  tip_gyro_radps_ = gyro_to;
}

std::optional<Timestamp> TurnHistory::oldest() const noexcept {
  if (num_knots_ == 0) return std::nullopt;
  return Timestamp{(newest_knot_ + 1 - static_cast<std::int64_t>(num_knots_)) * kKnot_us};
}

std::optional<Timestamp> TurnHistory::newest() const noexcept {
  if (num_knots_ == 0) return std::nullopt;
  return Timestamp{tip_us_};
}

bool TurnHistory::covers(Timestamp t) const noexcept {
  return num_knots_ > 0 && t >= *oldest() && t.us <= tip_us_;
}

const Eigen::Quaterniond& TurnHistory::knot(std::int64_t number) const noexcept {
  return knots_[static_cast<std::uint64_t>(number) % limits::kTurnKnots];
}

Eigen::Quaterniond TurnHistory::at(std::int64_t t_us) const noexcept {
  const std::int64_t number = t_us >> kKnotLog2_us;
  const std::int64_t since_us = t_us - number * kKnot_us;
  if (since_us == 0) return knot(number);
  const bool last = number == newest_knot_;  // what follows is the newest sample
  const std::int64_t span_us = last ? tip_us_ - number * kKnot_us : kKnot_us;
  return between(knot(number), last ? R_start_tip_ : knot(number + 1),
                 static_cast<double>(since_us) / static_cast<double>(span_us));
}

std::optional<Eigen::Quaterniond> TurnHistory::rotation(Timestamp t_a,
                                                        Timestamp t_b) const noexcept {
  if (!covers(t_a) || !covers(t_b)) return std::nullopt;
  return at(t_a.us).conjugate() * at(t_b.us);
}

double TurnHistory::max_rate_radps(std::int64_t from_us, std::int64_t to_us) const noexcept {
  double fastest = 0.0;
  const std::int64_t last = std::min((to_us - 1) >> kKnotLog2_us, newest_knot_);
  for (std::int64_t k = from_us >> kKnotLog2_us; k <= last; ++k) {
    const bool tip = k == newest_knot_;
    const std::int64_t span_us = tip ? tip_us_ - k * kKnot_us : kKnot_us;
    if (span_us == 0) continue;
    const Eigen::Quaterniond turn = knot(k).conjugate() * (tip ? R_start_tip_ : knot(k + 1));
    fastest = std::max(fastest, 2e6 * turn.vec().norm() / static_cast<double>(span_us));
  }
  return fastest;
}

bool TurnHistory::slices(Timestamp t_ref, Timestamp t_from, Timestamp t_to, double max_error_rad,
                         TurnSlices& out) const noexcept {
  if (!(t_from <= t_to) || !covers(t_from) || !covers(t_to) || !covers(t_ref)) return false;
  // In the middle of a slice the rotation is exact, at its ends off by half of what it turns.
  const double rate_radps = max_rate_radps(t_from.us, t_to.us);
  const auto slices_of = [&](int log2_us) {
    return static_cast<std::size_t>((t_to.us >> log2_us) - (t_from.us >> log2_us) + 1);
  };
  int log2_us = kMaxSliceLog2_us;
  while (log2_us > kMinSliceLog2_us && !(0.5e-6 * std::ldexp(rate_radps, log2_us) <= max_error_rad))
    --log2_us;
  while (slices_of(log2_us) > limits::kMaxTurnSlices) ++log2_us;

  const std::int64_t length_us = std::int64_t{1} << log2_us;
  out.t_ref = t_ref;
  out.length_log2_us = log2_us;
  out.begin_us = (t_from.us >> log2_us) * length_us;
  out.count = slices_of(log2_us);
  const Eigen::Quaterniond R_ref_start = at(t_ref.us).conjugate();
  const std::int64_t oldest_us = oldest()->us;
  for (std::size_t i = 0; i < out.count; ++i) {
    const std::int64_t begin_us = out.begin_of_us(i);
    // The middle of what is known of the slice.
    const std::int64_t known_from = std::max(begin_us, oldest_us);
    const std::int64_t known_to = std::min(begin_us + length_us, tip_us_);
    const std::int64_t middle_us = known_from + (known_to - known_from) / 2;
    const Eigen::Matrix3d R = (R_ref_start * at(middle_us)).toRotationMatrix();
    for (int k = 0; k < 9; ++k)
      out.R_ref_slice[i][static_cast<std::size_t>(k)] = static_cast<float>(R(k / 3, k % 3));
  }
  return true;
}

}  // namespace pled
