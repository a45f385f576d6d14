#include "src/apps/derived_truth.hpp"

#include <cmath>
#include <cstddef>

#include <Eigen/Core>

#include "pled_vins/geometry/so3.hpp"

namespace pled::apps {
namespace {

constexpr double kLongestStep_s = 0.0101;
constexpr double kWindow_s = 1.0;
constexpr double kShortest_s = 1.5;
constexpr double kMinShareOfSamples = 0.9;

/// What an ideal IMU would read, by central differences of the poses.
struct Ideal {
  double t_s = 0.0;
  Eigen::Vector3d rate_radps;
  Eigen::Vector3d force_mps2;
  Eigen::Vector3d velocity_mps;
};

/// Of poses[k], 0 < k < last. The two steps may differ by the rounding of stamps.
Ideal differentiate(std::span<const NavState> poses, std::size_t k, Timestamp origin) {
  const NavState& before = poses[k - 1];
  const NavState& here = poses[k];
  const NavState& after = poses[k + 1];
  const double h0_s = (here.t - before.t).seconds();
  const double h1_s = (after.t - here.t).seconds();
  const Eigen::Vector3d v0 = (here.p_wb - before.p_wb) / h0_s;
  const Eigen::Vector3d v1 = (after.p_wb - here.p_wb) / h1_s;
  const Eigen::Vector3d accel = 2.0 * (v1 - v0) / (h0_s + h1_s);
  Ideal out;
  out.t_s = (here.t - origin).seconds();
  out.velocity_mps = (h1_s * v0 + h0_s * v1) / (h0_s + h1_s);
  out.force_mps2 = here.q_wb.conjugate() * (accel - kGravityWorld);
  out.rate_radps = so3::log(before.q_wb.conjugate() * after.q_wb) / (h0_s + h1_s);
  return out;
}

/// Reading minus ideal reading, summed up to each sample.
struct Offset {
  double t_s = 0.0;
  Eigen::Vector3d gyro_sum;
  Eigen::Vector3d accel_sum;
};

std::vector<Offset> offsets(const std::vector<Ideal>& ideal, std::span<const ImuSample> imu,
                            Timestamp origin) {
  std::vector<Offset> out;
  Eigen::Vector3d gyro_sum = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_sum = Eigen::Vector3d::Zero();
  std::size_t k = 0;
  for (const ImuSample& sample : imu) {
    const double t_s = (sample.t - origin).seconds();
    while (k + 1 < ideal.size() && ideal[k + 1].t_s < t_s) ++k;
    if (t_s < ideal[k].t_s || k + 1 >= ideal.size()) continue;
    const double share = (t_s - ideal[k].t_s) / (ideal[k + 1].t_s - ideal[k].t_s);
    gyro_sum += Eigen::Vector3d::Map(sample.gyro_radps.data()) -
                ((1.0 - share) * ideal[k].rate_radps + share * ideal[k + 1].rate_radps);
    accel_sum += Eigen::Vector3d::Map(sample.accel_mps2.data()) -
                 ((1.0 - share) * ideal[k].force_mps2 + share * ideal[k + 1].force_mps2);
    out.push_back({t_s, gyro_sum, accel_sum});
  }
  return out;
}

double bias_sigma(double density, double walk) {
  return std::sqrt(density * density / kWindow_s + walk * walk * kWindow_s / 3.0);
}

}  // namespace

std::optional<DerivedTruth> derive_motion(std::span<const NavState> poses,
                                          std::span<const ImuSample> imu, const ImuNoise& noise) {
  if (poses.size() < 3 || (poses.back().t - poses.front().t).seconds() < kShortest_s)
    return std::nullopt;
  for (std::size_t k = 1; k < poses.size(); ++k)
    if ((poses[k].t - poses[k - 1].t).seconds() > kLongestStep_s) return std::nullopt;

  const Timestamp origin = poses.front().t;
  std::vector<Ideal> ideal;
  ideal.reserve(poses.size() - 2);
  for (std::size_t k = 1; k + 1 < poses.size(); ++k)
    ideal.push_back(differentiate(poses, k, origin));
  const std::vector<Offset> sums = offsets(ideal, imu, origin);

  DerivedTruth out;
  out.uncertainty.gyro_bias_radps = bias_sigma(noise.gyro_density, noise.gyro_walk);
  out.uncertainty.accel_bias_mps2 = bias_sigma(noise.accel_density, noise.accel_walk);
  std::size_t first = 0;  // the last sample before the window
  std::size_t end = 0;    // the first sample not before the state
  for (std::size_t k = 0; k < ideal.size(); ++k) {
    while (end < sums.size() && sums[end].t_s < ideal[k].t_s) ++end;
    while (first + 1 < end && sums[first + 1].t_s < ideal[k].t_s - kWindow_s) ++first;
    if (end == 0 || ideal[k].t_s - ideal.front().t_s < kWindow_s) continue;
    const auto samples = static_cast<double>(end - 1 - first);
    if (!(samples >= kMinShareOfSamples * kWindow_s * noise.rate_hz)) continue;
    NavState state = poses[k + 1];
    state.v_wb = ideal[k].velocity_mps;
    state.bg = (sums[end - 1].gyro_sum - sums[first].gyro_sum) / samples;
    state.ba = (sums[end - 1].accel_sum - sums[first].accel_sum) / samples;
    out.states.push_back(state);
  }
  if (out.states.empty()) return std::nullopt;
  return out;
}

}  // namespace pled::apps
