#pragma once

#include "pled_vins/backend/fusion_config.hpp"
#include "pled_vins/backend/robust_weight.hpp"
#include "pled_vins/core/config_issue.hpp"

namespace pled {

/// Tuning of the sliding-window estimator and of its start.
struct BackendConfig {
  double point_sigma_px = 0.15;  ///< least noise of a tracked point, one axis; more is measured
                                 ///< while tracking, 0.05 ... 10
  double event_point_sigma_px = 0.4;  ///< the same of an event point, 0.05 ... 10
  double line_sigma_px = 0.5;         ///< the same of a line's end, across the line, 0.05 ... 10
  double start_sigma_px = 0.7;        ///< the same until the estimator has started, 0.05 ... 10
  double robust_scale = 2.0;          ///< Cauchy scale in sigmas of a point, 0.5 ... 100
  int max_iterations = 8;             ///< solver steps a frame, 1 ... 50
  int settled_iterations = 4;  ///< the same once it has moved for 2 s since its start, 1 ... 50
  double keyframe_parallax_px =
      8.0;  ///< rotation-free parallax that makes a keyframe, at f = 200 px, 1 ... 100
  int min_observations = 3;             ///< of a point before it takes part, 2 ... 11
  int min_line_observations = 4;        ///< of a line before it takes part, 2 ... 11
  double imu_noise_scale = 1.0;         ///< multiplies the calibrated densities, 0.1 ... 1000
  bool estimate_time_shift = false;     ///< refine the camera-IMU time offset online
  bool find_time_shift = true;          ///< find a gross offset when no start succeeds
  bool estimate_extrinsic = false;      ///< refine T_body_cam online
  double time_shift_sigma_s = 0.005;    ///< prior when refined, 1e-5 ... 0.1
  double extrinsic_sigma_m = 0.01;      ///< prior when refined, 1e-4 ... 1
  double extrinsic_sigma_rad = 0.01;    ///< prior when refined, 1e-4 ... 1
  double gyro_bias_sigma_radps = 0.05;  ///< prior at start, 1e-4 ... 1
  double accel_bias_sigma_mps2 = 0.1;   ///< prior at start, 1e-3 ... 5
  double gravity_mps2 = 9.81;           ///< magnitude, 9.7 ... 9.9
  double init_min_span_s = 0.4;         ///< shortest motion to start from, 0.2 ... 5
  double init_max_span_s = 2.4;         ///< longest motion to look back at, 0.3 ... 5
  double init_max_scale_sigma =
      0.1;                    ///< largest accepted relative uncertainty of scale, 0.005 ... 1
  RobustWeightConfig robust;  ///< the weight of a feature by its errors
  FusionConfig fusion;        ///< and how what time tells goes into it
};

[[nodiscard]] constexpr ConfigIssue check(const BackendConfig& c) noexcept {
  if (!(c.point_sigma_px >= 0.05 && c.point_sigma_px <= 10))
    return {"backend.point_sigma_px", "must be in [0.05, 10]"};
  if (!(c.event_point_sigma_px >= 0.05 && c.event_point_sigma_px <= 10))
    return {"backend.event_point_sigma_px", "must be in [0.05, 10]"};
  if (!(c.line_sigma_px >= 0.05 && c.line_sigma_px <= 10))
    return {"backend.line_sigma_px", "must be in [0.05, 10]"};
  if (!(c.start_sigma_px >= 0.05 && c.start_sigma_px <= 10))
    return {"backend.start_sigma_px", "must be in [0.05, 10]"};
  if (!(c.robust_scale >= 0.5 && c.robust_scale <= 100))
    return {"backend.robust_scale", "must be in [0.5, 100]"};
  if (!(c.max_iterations >= 1 && c.max_iterations <= 50))
    return {"backend.max_iterations", "must be in [1, 50]"};
  if (!(c.settled_iterations >= 1 && c.settled_iterations <= 50))
    return {"backend.settled_iterations", "must be in [1, 50]"};
  if (!(c.keyframe_parallax_px >= 1 && c.keyframe_parallax_px <= 100))
    return {"backend.keyframe_parallax_px", "must be in [1, 100]"};
  if (!(c.min_observations >= 2 && c.min_observations <= 11))
    return {"backend.min_observations", "must be in [2, 11]"};
  if (!(c.min_line_observations >= 2 && c.min_line_observations <= 11))
    return {"backend.min_line_observations", "must be in [2, 11]"};
  if (!(c.imu_noise_scale >= 0.1 && c.imu_noise_scale <= 1000))
    return {"backend.imu_noise_scale", "must be in [0.1, 1000]"};
  if (!(c.time_shift_sigma_s >= 1e-5 && c.time_shift_sigma_s <= 0.1))
    return {"backend.time_shift_sigma_s", "must be in [0.00001, 0.1]"};
  if (!(c.extrinsic_sigma_m >= 1e-4 && c.extrinsic_sigma_m <= 1))
    return {"backend.extrinsic_sigma_m", "must be in [0.0001, 1]"};
  if (!(c.extrinsic_sigma_rad >= 1e-4 && c.extrinsic_sigma_rad <= 1))
    return {"backend.extrinsic_sigma_rad", "must be in [0.0001, 1]"};
  if (!(c.gyro_bias_sigma_radps >= 1e-4 && c.gyro_bias_sigma_radps <= 1))
    return {"backend.gyro_bias_sigma_radps", "must be in [0.0001, 1]"};
  if (!(c.accel_bias_sigma_mps2 >= 1e-3 && c.accel_bias_sigma_mps2 <= 5))
    return {"backend.accel_bias_sigma_mps2", "must be in [0.001, 5]"};
  if (!(c.gravity_mps2 >= 9.7 && c.gravity_mps2 <= 9.9))
    return {"backend.gravity_mps2", "must be in [9.7, 9.9]"};
  if (!(c.init_min_span_s >= 0.2 && c.init_min_span_s <= 5))
    return {"backend.init_min_span_s", "must be in [0.2, 5]"};
  if (!(c.init_max_span_s >= 0.3 && c.init_max_span_s <= 5 &&
        c.init_max_span_s >= c.init_min_span_s))
    return {"backend.init_max_span_s", "must be in [0.3, 5] and at least init_min_span_s"};
  if (!(c.init_max_scale_sigma >= 0.005 && c.init_max_scale_sigma <= 1))
    return {"backend.init_max_scale_sigma", "must be in [0.005, 1]"};
  if (const ConfigIssue issue = check(c.robust); issue.key != nullptr) return issue;
  return check(c.fusion);
}
static_assert(check(BackendConfig{}).key == nullptr, "defaults must be valid");

}  // namespace pled
