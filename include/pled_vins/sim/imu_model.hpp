#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/sim/options.hpp"
#include "pled_vins/sim/trajectory.hpp"

namespace pled::sim {

/// Readings, and the biases that were in each.
struct SimulatedImu {
  std::vector<ImuSample> samples;
  std::vector<Eigen::Vector3d> gyro_bias_radps;
  std::vector<Eigen::Vector3d> accel_bias_mps2;
};

/// Inertial readings along a trajectory from time 0 to `duration_s`, both ends
/// included, at the options' rate:
///   gyro = w_b + b_g + n_g,   accel = R_bw (a_w - g_w) + b_a + n_a.
/// White noise of density s is drawn with deviation s / sqrt(dt); a bias walks by
/// s_walk sqrt(dt) from sample to sample. Same seed, same samples.
[[nodiscard]] SimulatedImu simulate_imu(const Trajectory& trajectory, double duration_s,
                                        const ImuOptions& options, std::uint64_t seed);

}  // namespace pled::sim
