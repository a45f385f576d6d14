#include "pled_vins/imu/dead_reckoning.hpp"

#include <array>
#include <cstddef>

#include "pled_vins/core/check.hpp"
#include "pled_vins/geometry/so3.hpp"
#include "src/imu/imu_step.hpp"

namespace pled {
namespace {

constexpr std::size_t kMaxSamples = 512;

/// From sample `a` to `b`, in either direction of time.
void step(const ImuSample& a, const ImuSample& b, const Eigen::Vector3d& gravity,
          NavState& x) noexcept {
  const double dt_s = (b.t - a.t).seconds();
  const Eigen::Vector3d rate = 0.5 * (imu_step::gyro(a) + imu_step::gyro(b)) - x.bg;
  const Eigen::Quaterniond q_b = (x.q_wb * so3::exp(rate * dt_s)).normalized();
  const Eigen::Vector3d accel =
      0.5 * (x.q_wb * (imu_step::accel(a) - x.ba) + q_b * (imu_step::accel(b) - x.ba)) + gravity;
  x.p_wb += dt_s * x.v_wb + 0.5 * dt_s * dt_s * accel;
  x.v_wb += dt_s * accel;
  x.q_wb = q_b;
  x.t = b.t;
}

/// Carries the state to another time. False when the inertial data do not lead there.
bool carry(const ImuHistory& imu, Timestamp to, const Eigen::Vector3d& gravity,
           NavState& x) noexcept {
  if (to == x.t) return true;
  const bool forward = to > x.t;
  std::array<ImuSample, kMaxSamples> samples;
  bool has_gap = false;
  const std::size_t n =
      forward ? imu.interval(x.t, to, samples, has_gap) : imu.interval(to, x.t, samples, has_gap);
  if (n < 2 || has_gap) return false;
  for (std::size_t k = 1; k < n; ++k) {
    if (forward) {
      step(samples[k - 1], samples[k], gravity, x);
    } else {
      step(samples[n - k], samples[n - k - 1], gravity, x);
    }
  }
  return true;
}

}  // namespace

std::size_t dead_reckon(const ImuHistory& imu, const NavState& known, double gravity_mps2,
                        std::span<const Timestamp> times, std::span<Pose> T_world_body) noexcept {
  PLED_CHECK(T_world_body.size() >= times.size());
  const Eigen::Vector3d gravity(0.0, 0.0, -gravity_mps2);
  std::size_t newer = 0;  // times after the known state
  while (newer < times.size() && times[newer] > known.t) ++newer;
  NavState x = known;
  for (std::size_t i = newer; i-- > 0;) {
    if (!carry(imu, times[i], gravity, x)) return 0;
    T_world_body[i] = x.T_world_body();
  }
  x = known;
  for (std::size_t i = newer; i < times.size(); ++i) {
    if (!carry(imu, times[i], gravity, x)) return i;
    T_world_body[i] = x.T_world_body();
  }
  return times.size();
}

}  // namespace pled
