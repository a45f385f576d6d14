#include "pled_vins/imu/imu_history.hpp"

#include <algorithm>
#include <cmath>

#include "pled_vins/core/check.hpp"
#include "src/imu/imu_step.hpp"

namespace pled {
namespace {

constexpr std::int64_t kMinGap_us = 25'000;
constexpr std::int64_t kGapMedians = 4;
constexpr std::size_t kMinSteps = 2;  // three samples

bool finite(const ImuSample& s) noexcept {
  const auto is_finite = [](double v) { return std::isfinite(v); };
  return std::ranges::all_of(s.gyro_radps, is_finite) &&
         std::ranges::all_of(s.accel_mps2, is_finite);
}

/// The largest ranges on the market: 4000 deg/s = 70 rad/s and 32 g = 314 m/s^2 (ICM-42688-P,
/// ADXL-class parts); beyond is a broken number.
constexpr double kMostGyro_radps = 75.0;
constexpr double kMostAccel_mps2 = 350.0;

bool in_range(const ImuSample& s) noexcept {
  return std::ranges::all_of(s.gyro_radps,
                             [](double v) { return std::abs(v) <= kMostGyro_radps; }) &&
         std::ranges::all_of(s.accel_mps2, [](double v) { return std::abs(v) <= kMostAccel_mps2; });
}

// A jump by more than this from one sample to the next, at most 25 ms apart, must be confirmed by a
// third. Ours: a hard landing shows 100 m/s^2 for longer than one sample.
constexpr double kGyroJump_radps = 8.0;
constexpr double kAccelJump_mps2 = 60.0;
constexpr std::int64_t kJumpWithin_us = 25'000;

bool jumps(const ImuSample& a, const ImuSample& b) noexcept {
  for (std::size_t k = 0; k < 3; ++k)
    if (std::abs(b.gyro_radps[k] - a.gyro_radps[k]) > kGyroJump_radps ||
        std::abs(b.accel_mps2[k] - a.accel_mps2[k]) > kAccelJump_mps2)
      return true;
  return false;
}

}  // namespace

bool ImuHistory::add(const ImuSample& sample) noexcept {
  if (!finite(sample)) {
    ++faults_.not_finite;
    return false;
  }
  if (!in_range(sample)) {
    ++faults_.implausible;
    return false;
  }
  if (size_ == 0) {
    append(sample);
    return true;
  }
  const ImuSample& last = (*this)[size_ - 1];
  const Timestamp newest = suspect_ ? suspect_->t : last.t;
  if (sample.t <= newest) {
    ++(sample.t == newest ? faults_.duplicates : faults_.backwards);
    return false;
  }
  if (suspect_) {
    const ImuSample suspect = *suspect_;
    suspect_.reset();
    const bool lone = jumps(suspect, sample) && !jumps(last, sample);
    if (lone)
      ++faults_.implausible;
    else
      append(suspect);
    append(sample);
    return true;
  }
  if ((sample.t - last.t).us <= kJumpWithin_us && jumps(last, sample))
    suspect_ = sample;
  else
    append(sample);
  return true;
}

void ImuHistory::append(const ImuSample& sample) noexcept {
  if (size_ > 0) {
    const Duration dt = sample.t - (*this)[size_ - 1].t;
    if (dt > gap_threshold()) ++faults_.gaps;
    recent_dt_us_[dt_count_ % recent_dt_us_.size()] = dt.us;
    ++dt_count_;
  }
  if (size_ == samples_.size()) {
    if (samples_[head_].t >= released_) ++faults_.overwritten;
    head_ = (head_ + 1) % samples_.size();
    --size_;
  }
  samples_[(head_ + size_) % samples_.size()] = sample;
  ++size_;
}

void ImuHistory::clear() noexcept {
  forget_samples();
  faults_ = ImuFaults{};
}

void ImuHistory::forget_samples() noexcept {
  head_ = 0;
  size_ = 0;
  dt_count_ = 0;
  suspect_.reset();
  released_ = Timestamp{std::numeric_limits<std::int64_t>::min()};
}

void ImuHistory::release_before(Timestamp t) noexcept { released_ = std::max(released_, t); }

const ImuSample& ImuHistory::operator[](std::size_t i) const noexcept {
  PLED_CHECK(i < size_);
  return samples_[(head_ + i) % samples_.size()];
}

std::optional<Timestamp> ImuHistory::newest() const noexcept {
  if (size_ == 0) return std::nullopt;
  return (*this)[size_ - 1].t;
}

std::optional<Timestamp> ImuHistory::oldest() const noexcept {
  if (size_ == 0) return std::nullopt;
  return (*this)[0].t;
}

Duration ImuHistory::median_period() const noexcept {
  if (dt_count_ < kMinSteps) return {};
  std::array<std::int64_t, std::tuple_size_v<decltype(recent_dt_us_)>> sorted = recent_dt_us_;
  const std::size_t n = std::min(dt_count_, sorted.size());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(n / 2);
  std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<std::ptrdiff_t>(n));
  return {*middle};
}

Duration ImuHistory::gap_threshold() const noexcept {
  return {std::max(kGapMedians * median_period().us, kMinGap_us)};
}

std::size_t ImuHistory::lower_bound(Timestamp t) const noexcept {
  std::size_t low = 0;
  std::size_t high = size_;
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if ((*this)[middle].t < t) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

ImuSample ImuHistory::sample_at(Timestamp t) const noexcept {
  const std::size_t at = lower_bound(t);
  ImuSample s = (*this)[at == size_ ? size_ - 1 : at];
  if (at > 0 && at < size_ && s.t != t) {
    const ImuSample& start = (*this)[at - 1];
    const ImuSample& end = (*this)[at];
    const ImuSample* before = at > 1 ? &(*this)[at - 2] : nullptr;
    const ImuSample* after = at + 1 < size_ ? &(*this)[at + 1] : nullptr;
    const double u = (t - start.t).seconds() / (end.t - start.t).seconds();
    const imu_step::Weights w = imu_step::weights_at(u, before, start, end, after);
    const Eigen::Vector3d gyro_radps =
        imu_step::blend(w, before, start, end, after, imu_step::gyro);
    const Eigen::Vector3d accel_mps2 =
        imu_step::blend(w, before, start, end, after, imu_step::accel);
    for (std::size_t k = 0; k < 3; ++k) {
      s.gyro_radps[k] = gyro_radps[static_cast<Eigen::Index>(k)];
      s.accel_mps2[k] = accel_mps2[static_cast<Eigen::Index>(k)];
    }
  }
  s.t = t;
  return s;
}

bool ImuHistory::cover(Timestamp from, Timestamp to, Cover& c) const noexcept {
  if (size_ == 0 || !(to > from)) return false;
  const Duration threshold = gap_threshold();
  if ((*this)[0].t - from > threshold || to - (*this)[size_ - 1].t > threshold) return false;
  c.start = sample_at(from);
  c.end = sample_at(to);
  // The open interval: samples at exactly `from` or `to` are the start and the end.
  c.first = lower_bound(from + Duration{1});
  c.count = std::max(lower_bound(to), c.first) - c.first;
  // The steps that the span touches reach from the sample at or before its start to the one at
  // or after its end.
  const std::size_t begin = c.first > 0 ? c.first - 1 : 0;
  const std::size_t end = std::min(c.first + c.count, size_ - 1);
  c.has_gap = false;
  for (std::size_t i = begin; i < end; ++i) {
    c.has_gap = c.has_gap || (*this)[i + 1].t - (*this)[i].t > threshold;
  }
  return true;
}

const ImuSample& ImuHistory::covered(const Cover& c, std::size_t i) const noexcept {
  if (i == 0) return c.start;
  if (i <= c.count) return (*this)[c.first + i - 1];
  return c.end;
}

std::size_t ImuHistory::interval(Timestamp from, Timestamp to, std::span<ImuSample> out,
                                 bool& has_gap) const noexcept {
  Cover c;
  if (!cover(from, to, c) || c.size() > out.size()) return 0;
  for (std::size_t i = 0; i < c.size(); ++i) out[i] = covered(c, i);
  has_gap = c.has_gap;
  return c.size();
}

std::optional<Eigen::Quaterniond> ImuHistory::rotation(
    Timestamp from, Timestamp to, const Eigen::Vector3d& gyro_bias_radps) const noexcept {
  if (from == to && size_ > 0) return Eigen::Quaterniond::Identity();
  Cover c;
  if (!cover(from, to, c) || c.has_gap) return std::nullopt;
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  for (std::size_t i = 0; i + 1 < c.size(); ++i) {
    const ImuSample* before = i > 0 ? &covered(c, i - 1) : nullptr;
    const ImuSample& start = covered(c, i);
    const ImuSample& end = covered(c, i + 1);
    const ImuSample* after = i + 2 < c.size() ? &covered(c, i + 2) : nullptr;
    const imu_step::Weights w = imu_step::weights_at(0.5, before, start, end, after);
    const Eigen::Vector3d wm =
        imu_step::blend(w, before, start, end, after, imu_step::gyro) - gyro_bias_radps;
    q = q * so3::exp(imu_step::full_rotation(imu_step::gyro(start) - gyro_bias_radps, wm,
                                             imu_step::gyro(end) - gyro_bias_radps,
                                             (end.t - start.t).seconds()));
  }
  return q.normalized();
}

}  // namespace pled
