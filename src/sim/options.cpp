#include "pled_vins/sim/options.hpp"

#include "pled_vins/geometry/so3.hpp"

namespace pled::sim {

CameraCalibration davis240c_camera() noexcept {
  CameraCalibration c;
  c.width_px = 240;
  c.height_px = 180;
  c.fx_px = 199.092;
  c.fy_px = 198.829;
  c.cx_px = 132.192;
  c.cy_px = 110.713;
  c.distortion = Distortion::kRadtan;
  c.coeffs = {-0.36844, 0.15095, -0.000296, -0.000759, 0.0};
  const Pose T_cam_body{so3::exp(Eigen::Vector3d{0.010, -0.014, 0.009}),
                        Eigen::Vector3d{-0.008, 0.012, -0.015}};
  c.T_body_cam = T_cam_body.inverse();
  return c;
}

std::optional<SimulationOptions> preset(std::string_view name) noexcept {
  SimulationOptions options;
  options.camera = davis240c_camera();
  if (name == "demo") return options;
  options.moving = MovingLevel::kNone;
  if (name == "test") {
    options.duration_s = 4.0;
    return options;
  }
  if (name == "hall") {
    options.scale = 5.0;
    options.pace = 0.4;
    return options;
  }
  if (name == "still") {
    options.start = StartKind::kStill;
    return options;
  }
  return std::nullopt;
}

namespace {

ConfigIssue check_sensors(const SimulationOptions& o) noexcept {
  const ImuNoise& n = o.imu.noise;
  if (!(n.rate_hz >= 50 && n.rate_hz <= 4000)) return {"imu.rate_hz", "must be in [50, 4000]"};
  if (!(n.accel_density >= 0 && n.accel_walk >= 0 && n.gyro_density >= 0 && n.gyro_walk >= 0))
    return {"imu.noise", "must be >= 0"};
  if (!(o.imu.gyro_bias_radps >= 0 && o.imu.accel_bias_mps2 >= 0))
    return {"imu.bias", "must be >= 0"};
  if (!(o.frames.rate_hz >= 1 && o.frames.rate_hz <= 200))
    return {"frames.rate_hz", "must be in [1, 200]"};
  if (!(o.frames.exposure_s >= 0 && o.frames.exposure_s * o.frames.rate_hz <= 1))
    return {"frames.exposure_s", "must be in [0, 1 / rate]"};
  if (!(o.frames.blur_samples >= 1 && o.frames.blur_samples <= 63 &&
        o.frames.blur_samples % 2 == 1))
    return {"frames.blur_samples", "must be odd, in [1, 63]"};
  if (!(o.frames.noise_grey >= 0)) return {"frames.noise_grey", "must be >= 0"};
  const EventOptions& e = o.events;
  if (!(e.threshold >= 0.05 && e.threshold <= 1))
    return {"events.threshold", "must be in [0.05, 1]"};
  if (!(e.mismatch >= 0 && e.mismatch <= 0.3)) return {"events.mismatch", "must be in [0, 0.3]"};
  if (!(e.refractory_s >= 0 && e.refractory_s <= 0.01))
    return {"events.refractory_s", "must be in [0, 0.01]"};
  if (!(e.noise_rate_hz >= 0 && e.noise_rate_hz <= 100))
    return {"events.noise_rate_hz", "must be in [0, 100]"};
  if (!(e.max_step_s >= 1e-4 && e.max_step_s <= 0.02))
    return {"events.max_step_s", "must be in [0.0001, 0.02]"};
  if (!(e.max_motion_px >= 0.05 && e.max_motion_px <= 2))
    return {"events.max_motion_px", "must be in [0.05, 2]"};
  return {};
}

}  // namespace

ConfigIssue check(const SimulationOptions& o) noexcept {
  if (!(o.duration_s >= 0.1 && o.duration_s <= 600)) return {"duration", "must be in [0.1, 600] s"};
  if (!(o.scale >= 0.5 && o.scale <= 10)) return {"scale", "must be in [0.5, 10]"};
  if (!(o.pace >= 0.1 && o.pace <= 2)) return {"pace", "must be in [0.1, 2]"};
  if (!(o.still_s >= 0 && o.still_s <= 60)) return {"still_s", "must be in [0, 60]"};
  // The EVT3 format addresses 11 bits; a vector word group spans 32 pixels.
  if (!(o.camera.width_px >= 32 && o.camera.width_px <= 2048 && o.camera.height_px >= 16 &&
        o.camera.height_px <= 2048))
    return {"camera.resolution", "must be from 32x16 to 2048x2048"};
  if (!(o.camera.fx_px > 0 && o.camera.fy_px > 0)) return {"camera.intrinsics", "must be > 0"};
  return check_sensors(o);
}

}  // namespace pled::sim
