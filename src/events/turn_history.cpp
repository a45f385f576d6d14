#include "pled_vins/events/turn_history.hpp"

#include <algorithm>
#include <cmath>

#include "pled_vins/core/check.hpp"
#include "pled_vins/geometry/so3.hpp"

namespace pled {
namespace {

constexpr int kMinSliceLog2_us = 6;  // 64 us: a fast sensor's time resolution
constexpr int kMaxSliceLog2_us = TurnHistory::kKnotLog2_us;

/// Exp(2 half) of a turn by at most some hundredths of a radian, to less than 1e-7 rad.
Eigen::Quaterniond small_turn(const Eigen::Vector3d& half_rad) noexcept {
  const double square = half_rad.squaredNorm();
  const Eigen::Vector3d v = (1.0 - square / 6.0) * half_rad;
  return {1.0 - 0.5 * square, v.x(), v.y(), v.z()};
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
      begin(sample, gyro_bias_radps, R_cam_body);
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
    begin(sample, gyro_bias_radps, R_cam_body);
  }
  return sound;
}

void TurnHistory::clear() noexcept {
  has_sample_ = false;
  num_knots_ = 0;
}

void TurnHistory::begin(const ImuSample& sample, const Eigen::Vector3d& gyro_bias_radps,
                        const Eigen::Quaterniond& R_cam_body) noexcept {
  has_sample_ = true;
  tip_us_ = sample.t.us;
  R_start_tip_.setIdentity();
  tip_gyro_radps_ = Eigen::Map<const Eigen::Vector3d>(sample.gyro_radps.data());
  newest_knot_ = (tip_us_ - 1) >> kKnotLog2_us;
  if (tip_us_ == (newest_knot_ + 1) * kKnot_us)
    add_knot(R_cam_body * (tip_gyro_radps_ - gyro_bias_radps), Eigen::Vector3d::Zero());
}

void TurnHistory::add_knot(const Eigen::Vector3d& rate_radps,
                           const Eigen::Vector3d& accel_radps2) noexcept {
  ++newest_knot_;
  num_knots_ = std::min(num_knots_ + 1, limits::kTurnKnots);
  knots_[static_cast<std::uint64_t>(newest_knot_) % limits::kTurnKnots] = {
      R_start_tip_, rate_radps.cast<float>(), accel_radps2.cast<float>()};
}

void TurnHistory::integrate_to(const ImuSample& sample, const Eigen::Vector3d& gyro_bias_radps,
                               const Eigen::Quaterniond& R_cam_body) noexcept {
  const std::int64_t from_us = tip_us_;
  const Eigen::Vector3d gyro_from = tip_gyro_radps_;
  const Eigen::Vector3d gyro_to = Eigen::Map<const Eigen::Vector3d>(sample.gyro_radps.data());
  const double step_s = static_cast<double>(sample.t.us - from_us) * 1e-6;
  const Eigen::Vector3d rate_from = R_cam_body * (gyro_from - gyro_bias_radps);
  const Eigen::Vector3d accel = R_cam_body * (gyro_to - gyro_from) / step_s;
  while (tip_us_ < sample.t.us) {
    const std::int64_t next_knot_us = (newest_knot_ + 1) * kKnot_us;
    const std::int64_t to_us = std::min(next_knot_us, sample.t.us);
    const double begin_s = static_cast<double>(tip_us_ - from_us) * 1e-6;
    const double end_s = static_cast<double>(to_us - from_us) * 1e-6;
    // The rate is linear between samples, so its mean over a part is that in the part's middle.
    const Eigen::Vector3d rate = rate_from + 0.5 * (begin_s + end_s) * accel;
    R_start_tip_ = (R_start_tip_ * so3::exp(rate * (end_s - begin_s))).normalized();
    tip_us_ = to_us;
    if (to_us == next_knot_us) add_knot(rate_from + end_s * accel, accel);
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

const TurnHistory::Knot& TurnHistory::knot(std::int64_t number) const noexcept {
  return knots_[static_cast<std::uint64_t>(number) % limits::kTurnKnots];
}

Eigen::Quaterniond TurnHistory::at(std::int64_t t_us) const noexcept {
  const Knot& before = knot(t_us >> kKnotLog2_us);
  const double dt_s = static_cast<double>(t_us & (kKnot_us - 1)) * 1e-6;
  const Eigen::Vector3d half_rad = 0.5 * dt_s * before.rate_radps.cast<double>() +
                                   0.25 * dt_s * dt_s * before.accel_radps2.cast<double>();
  return before.R_start_knot * small_turn(half_rad);
}

std::optional<Eigen::Quaterniond> TurnHistory::rotation(Timestamp t_a,
                                                        Timestamp t_b) const noexcept {
  if (!covers(t_a) || !covers(t_b)) return std::nullopt;
  return at(t_a.us).conjugate() * at(t_b.us);
}

double TurnHistory::max_rate_radps(std::int64_t from_us, std::int64_t to_us) const noexcept {
  constexpr float kKnot_s = 1e-6F * static_cast<float>(kKnot_us);
  float fastest = 0.0F;
  for (std::int64_t k = from_us >> kKnotLog2_us; k <= to_us >> kKnotLog2_us; ++k) {
    const Knot& begin = knot(k);
    const Eigen::Vector3f end_radps = begin.rate_radps + kKnot_s * begin.accel_radps2;
    fastest = std::max({fastest, begin.rate_radps.squaredNorm(), end_radps.squaredNorm()});
  }
  return std::sqrt(static_cast<double>(fastest));
}

bool TurnHistory::slices(Timestamp t_ref, Timestamp t_from, Timestamp t_to, double max_error_rad,
                         TurnSlices& out) const noexcept {
  static_assert(limits::kMaxTurnSlices > limits::kTurnKnots, "slices of a knot's length suffice");
  if (!(t_from <= t_to) || !covers(t_from) || !covers(t_to) || !covers(t_ref)) return false;
  // In the middle of a slice the rotation is exact, at its ends off by half of what it turns.
  const double off_radpus = 0.5e-6 * max_rate_radps(t_from.us, t_to.us);
  const auto slices_of = [&](int log2_us) {
    return static_cast<std::size_t>((t_to.us >> log2_us) - (t_from.us >> log2_us) + 1);
  };
  const auto off_rad = [&](int log2_us) {
    return off_radpus * static_cast<double>(std::int64_t{1} << log2_us);
  };
  int log2_us = kMaxSliceLog2_us;
  while (log2_us > kMinSliceLog2_us && !(off_rad(log2_us) <= max_error_rad)) --log2_us;
  while (slices_of(log2_us) > limits::kMaxTurnSlices) ++log2_us;

  out.t_ref = t_ref;
  out.length_log2_us = log2_us;
  out.begin_us = t_from.us >> log2_us << log2_us;
  out.count = slices_of(log2_us);
  const Eigen::Quaterniond R_ref_start = at(t_ref.us).conjugate();
  for (std::size_t i = 0; i < out.count; ++i) {
    const std::int64_t middle_us = out.begin_of_us(i) + (std::int64_t{1} << log2_us) / 2;
    const Eigen::Matrix3d R = (R_ref_start * at(middle_us)).toRotationMatrix();
    for (int k = 0; k < 9; ++k)
      out.R_ref_slice[i][static_cast<std::size_t>(k)] = static_cast<float>(R(k / 3, k % 3));
  }
  return true;
}

}  // namespace pled
