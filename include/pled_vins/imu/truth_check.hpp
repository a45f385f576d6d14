#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/imu/preintegration.hpp"

namespace pled {

/// Standard deviations of true states, for each axis. Those of position, attitude and velocity
/// are independent between the two ends of an interval; the others are common to both.
struct TruthUncertainty {
  double position_m = 0.0;
  double attitude_rad = 0.0;
  double velocity_mps = 0.0;
  double gyro_bias_radps = 0.0;
  double accel_bias_mps2 = 0.0;
  double frame_tilt_rad = 0.0;  ///< of the reference's z axis against gravity
};

/// The uncertainty that a reference shows by itself while the body stands still at its start
/// (until 0.5 s before its speed reaches 0.03 m/s): how much its states change over interval_s,
/// how far the mean gyro reading is from its bias, and the mean specific force from its vertical.
/// nullopt when that is shorter than interval_s + 1 s or has no IMU samples. No integration.
[[nodiscard]] std::optional<TruthUncertainty> measure_standing_truth(
    std::span<const NavState> truth, std::span<const ImuSample> imu, double interval_s) noexcept;

/// How IMU data integrated from true states agree with the true states reached. Errors are those
/// of Preintegration::residual(), rows p, theta, v; NaN when nothing was compared.
struct PreintegrationCheck {
  std::size_t compared = 0;            ///< intervals
  std::size_t skipped = 0;             ///< without truth at the end, without samples, or with a gap
  double mean_nees_per_dof = 0.0;      ///< mean of e^T P^-1 e / 9: 1 when P is right
  double position_nees_per_dof = 0.0;  ///< the same of each group alone, / 3
  double attitude_nees_per_dof = 0.0;
  double velocity_nees_per_dof = 0.0;
  double position_rms_m = 0.0;  ///< root mean square of the error's length
  double attitude_rms_rad = 0.0;
  double velocity_rms_mps = 0.0;
};

/// Integrates `imu` from each true state, with its own biases, to the true state interval_s later,
/// in intervals that follow one another without overlap. P is the preintegration's covariance
/// plus `uncertainty` of both ends.
///
/// @param[in] truth  states of a reference system, biases included; increasing stamps.
/// @param[in] imu    increasing stamps.
/// @param[in] interval_s  > 0, up to 5 s; truth within 1 ms of the wanted end is used, at its own
/// stamp. Not for the data path: it keeps an ImuHistory on the stack (about 350 kB).
[[nodiscard]] PreintegrationCheck check_preintegration(
    std::span<const NavState> truth, std::span<const ImuSample> imu, double interval_s,
    const ImuNoise& noise, const TruthUncertainty& uncertainty) noexcept;

}  // namespace pled
