#include "pled_vins/pipeline/time_shift_search.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "pled_vins/core/limits.hpp"

namespace pled {
namespace {

constexpr std::size_t kFewestPoints = 12;
constexpr std::size_t kFewestIntervals = 40;  // three equations each, for twelve unknowns
constexpr double kShortest_s = 1.8;
constexpr int kSteps = 20;  // to either side
constexpr std::int64_t kStep_us = 5000;
constexpr double kLeastTurning_radps = 0.03;  // standard deviation of the gyro: below, all is noise
constexpr double kLeastGain = 0.75;           // misfit at the best offset over that at none
constexpr std::int64_t kLeastShift_us = 12'000;
constexpr double kRobust_rad = 2e-3;  // half a pixel at f = 250 px
constexpr int kRobustRounds = 6;

using Row = Eigen::Matrix<double, 4, 1>;

bool counts(const PointMeasurement& point, std::uint8_t camera) noexcept {
  return point.track_length >= 2 && point.camera == camera;
}

/// Turning rate of the camera that explains its points' motion best; robust against movers.
Eigen::Vector3d image_turn(const FrameMeasurement& frame, std::uint8_t camera,
                           double dt_s) noexcept {
  std::array<double, limits::kMaxPoints> weight;
  weight.fill(1.0);
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();
  for (int round = 0; round < kRobustRounds; ++round) {
    Eigen::Matrix3d H = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < frame.points.size(); ++i) {
      const PointMeasurement& p = frame.points[i];
      if (!counts(p, camera)) continue;
      const double x = p.bearing_xy[0];
      const double y = p.bearing_xy[1];
      Eigen::Matrix<double, 2, 3> J;  // image motion of a distant point by the camera's turn
      J << x * y, -(1 + x * x), y, 1 + y * y, -x * y, -x;
      const Eigen::Vector2d seen(p.bearing_rate_xyps[0], p.bearing_rate_xyps[1]);
      const Eigen::Vector2d r = (seen - J * rate) * (dt_s / kRobust_rad);
      if (round > 0) weight[i] = 1.0 / (1.0 + r.squaredNorm());
      if (!seen.allFinite()) continue;
      H += weight[i] * J.transpose() * J;
      b += weight[i] * J.transpose() * seen;
    }
    rate = H.ldlt().solve(b);
  }
  return rate;
}

/// Angle turned since the oldest sample, by the gyro, at any time. A sum of vectors: turns of a
/// tenth of a second are small enough for that.
class TurnedAngle {
 public:
  explicit TurnedAngle(const ImuHistory& imu) noexcept : imu_(imu), sum_(Eigen::Vector3d::Zero()) {}

  /// Times must not go back.
  [[nodiscard]] Eigen::Vector3d at(Timestamp t) noexcept {
    while (next_ < imu_.size() && imu_[next_].t <= t) {
      sum_ += 0.5 * (gyro(next_ - 1) + gyro(next_)) * (imu_[next_].t - imu_[next_ - 1].t).seconds();
      ++next_;
    }
    return sum_ + gyro(next_ - 1) * (t - imu_[next_ - 1].t).seconds();
  }

 private:
  [[nodiscard]] Eigen::Vector3d gyro(std::size_t i) const noexcept {
    return Eigen::Map<const Eigen::Vector3d>(imu_[i].gyro_radps.data());
  }
  const ImuHistory& imu_;
  std::size_t next_ = 1;
  Eigen::Vector3d sum_;
};

/// Sum of squares that remains after fitting `image` = M * (`gyro`, 1).
struct Fit {
  Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> b = Eigen::Matrix<double, 4, 3>::Zero();
  double squares = 0;
  double count = 0;

  void add(const Eigen::Vector3d& gyro_radps, const Eigen::Vector3d& image_radps) noexcept {
    const Row row(gyro_radps.x(), gyro_radps.y(), gyro_radps.z(), 1.0);
    H += row * row.transpose();
    b += row * image_radps.transpose();
    squares += image_radps.squaredNorm();
    count += 1;
  }
  [[nodiscard]] double rest() const noexcept {
    const Eigen::Matrix4d H_sure = H + 1e-9 * Eigen::Matrix4d::Identity();
    return squares - (b.transpose() * H_sure.ldlt().solve(b)).trace();
  }
  /// Largest standard deviation of the gyro's axes.
  [[nodiscard]] double turning_radps() const noexcept {
    const Eigen::Vector3d mean = H.block<3, 1>(0, 3) / count;
    const Eigen::Vector3d variance =
        H.diagonal().head<3>() / count - Eigen::Vector3d(mean.cwiseAbs2());
    return std::sqrt(std::max(0.0, variance.maxCoeff()));
  }
};

}  // namespace

void TimeShiftSearch::observe(Timestamp from, Timestamp to, const FrameMeasurement& frame,
                              std::uint8_t camera) noexcept {
  std::size_t followed = 0;
  for (const PointMeasurement& p : frame.points) followed += counts(p, camera);
  if (followed < kFewestPoints || !(to > from)) return;
  if (size_ == kIntervals) {
    std::move(turns_.begin() + 1, turns_.end(), turns_.begin());
    --size_;
  }
  turns_[size_++] = {from, to, image_turn(frame, camera, (to - from).seconds())};
}

std::optional<Duration> TimeShiftSearch::find(const ImuHistory& imu) const noexcept {
  const Duration reach{kSteps * kStep_us};
  if (imu.size() < 2) return std::nullopt;
  const auto covered = [&](const Turn& t) {
    return t.from - reach >= imu[0].t && t.to + reach <= *imu.newest();
  };
  std::size_t first = 0;
  std::size_t end = size_;
  while (first < end && !covered(turns_[first])) ++first;
  while (end > first && !covered(turns_[end - 1])) --end;
  if (end - first < kFewestIntervals) return std::nullopt;
  if ((turns_[end - 1].to - turns_[first].from).seconds() < kShortest_s) return std::nullopt;
  std::array<double, 2 * kSteps + 1> rest{};
  for (int k = -kSteps; k <= kSteps; ++k) {
    const Duration shift{k * kStep_us};
    TurnedAngle angle(imu);
    Fit fit;
    Timestamp at = turns_[first].from;
    Eigen::Vector3d before = angle.at(at + shift);
    for (std::size_t i = first; i < end; ++i) {
      const Turn& turn = turns_[i];
      if (turn.from != at) before = angle.at(turn.from + shift);
      const Eigen::Vector3d after = angle.at(turn.to + shift);
      fit.add((after - before) / (turn.to - turn.from).seconds(), turn.rate_radps);
      at = turn.to;
      before = after;
    }
    if (k == 0 && fit.turning_radps() < kLeastTurning_radps) return std::nullopt;
    rest[static_cast<std::size_t>(k + kSteps)] = fit.rest();
  }
  const auto best =
      static_cast<std::size_t>(std::min_element(rest.begin(), rest.end()) - rest.begin());
  if (best == 0 || best + 1 == rest.size()) return std::nullopt;  // lies further out than we look
  if (!(rest[best] < kLeastGain * kLeastGain * rest[kSteps])) return std::nullopt;
  // Vertex of the parabola through the three lowest.
  const double bend = rest[best - 1] - 2 * rest[best] + rest[best + 1];
  const double vertex = bend > 0 ? 0.5 * (rest[best - 1] - rest[best + 1]) / bend : 0.0;
  const double steps = static_cast<double>(best) - kSteps + vertex;
  const Duration shift{std::llround(steps * static_cast<double>(kStep_us))};
  if (std::abs(shift.us) < kLeastShift_us) return std::nullopt;
  return shift;
}

}  // namespace pled
