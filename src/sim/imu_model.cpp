#include "pled_vins/sim/imu_model.hpp"

#include <cmath>

#include "pled_vins/imu/preintegration.hpp"
#include "src/sim/random.hpp"

namespace pled::sim {
namespace {

Eigen::Vector3d gaussian3(Random& random, double sigma) noexcept {
  const double x = random.gaussian();
  const double y = random.gaussian();
  const double z = random.gaussian();
  return sigma * Eigen::Vector3d{x, y, z};
}

}  // namespace

SimulatedImu simulate_imu(const Trajectory& trajectory, double duration_s,
                          const ImuOptions& options, std::uint64_t seed) {
  const ImuNoise& noise = options.noise;
  const double dt_s = 1.0 / noise.rate_hz;
  const double on = options.with_noise ? 1.0 : 0.0;
  Random random = stream(seed, Stream::kImu);
  Eigen::Vector3d bg = gaussian3(random, 1.0).normalized() * (on * options.gyro_bias_radps);
  Eigen::Vector3d ba = gaussian3(random, 1.0).normalized() * (on * options.accel_bias_mps2);

  const auto count = static_cast<std::size_t>(duration_s * noise.rate_hz + 1e-6) + 1;
  SimulatedImu out;
  out.samples.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Timestamp t{Duration::from_s(static_cast<double>(i) * dt_s).us};
    const Kinematics k = trajectory.at(t.seconds());
    const Eigen::Vector3d gyro =
        k.omega_b_radps + bg + gaussian3(random, on * noise.gyro_density / std::sqrt(dt_s));
    const Eigen::Vector3d accel = k.T_world_body.q.conjugate() * (k.a_wb_mps2 - kGravityWorld) +
                                  ba +
                                  gaussian3(random, on * noise.accel_density / std::sqrt(dt_s));
    out.samples.push_back({t, {gyro.x(), gyro.y(), gyro.z()}, {accel.x(), accel.y(), accel.z()}});
    out.gyro_bias_radps.push_back(bg);
    out.accel_bias_mps2.push_back(ba);
    bg += gaussian3(random, on * noise.gyro_walk * std::sqrt(dt_s));
    ba += gaussian3(random, on * noise.accel_walk * std::sqrt(dt_s));
  }
  return out;
}

}  // namespace pled::sim
