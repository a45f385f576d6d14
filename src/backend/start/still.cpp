#include "src/backend/start/still.hpp"

#include <algorithm>

#include <Eigen/Geometry>

#include "src/backend/start/gyro_bias.hpp"

namespace pled::start {
namespace {

constexpr double kImageSigmas = 2.0;  // median motion of a standing camera is 1.7 sigma
constexpr double kLargestMotion_m = 0.03;
constexpr double kLargestTurn_rad = 0.02;
constexpr double kLargestGyro_radps = 0.25;   // of a mean: no gyro worth using has a larger bias
constexpr double kGyroVibration_radps = 0.3;  // motors on, propellers idle: EuRoC shows 0.1
constexpr double kAccelVibration_mps2 = 3.0;  // EuRoC shows 1.3

}  // namespace

Stillness judge_stillness(const Tracks& tracks, const StartFrames& frames, const ImuHistory& imu,
                          const RigCalibration& rig, const BackendConfig& config,
                          ImuPath& path) noexcept {
  Stillness s;
  s.image_motion_px = median_motion_px(tracks, path, rig, false);
  s.image_still = s.image_motion_px < kImageSigmas * config.point_sigma_px;
  if (!s.image_still) return s;
  const Eigen::Vector3d mean_gyro = path.mean_gyro();
  const Eigen::Vector3d mean_accel = path.mean_accel();
  const bool quiet = mean_gyro.norm() < kLargestGyro_radps &&
                     path.gyro_std() < kGyroVibration_radps &&
                     path.accel_std() < kAccelVibration_mps2;
  if (!quiet) return s;
  // With mean rate and mean force as biases, rotation and displacement must stay near zero; a
  // velocity at frame 0 is allowed for, because vibration is cut off at an arbitrary phase.
  if (path.integrate(frames, imu, mean_gyro, mean_accel) != StartRefusal::kNone) return s;
  const PathPoint& last = path[path.size() - 1];
  const Eigen::Vector3d v = last.alpha / last.t_s;
  for (std::size_t k = 0; k < path.size(); ++k) {
    s.imu_turn_rad = std::max(s.imu_turn_rad, Eigen::AngleAxisd(path[k].R_0k).angle());
    s.imu_motion_m = std::max(s.imu_motion_m, (path[k].alpha - v * path[k].t_s).norm());
  }
  s.imu_still = s.imu_motion_m < kLargestMotion_m && s.imu_turn_rad < kLargestTurn_rad;
  return s;
}

}  // namespace pled::start
