#include "pled_vins/sim/options.hpp"

#include <cmath>
#include <numbers>

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

CameraCalibration camera_beside(const CameraCalibration& beside) noexcept {
  CameraCalibration c;
  c.width_px = 346;
  c.height_px = 260;
  c.fx_px = c.fy_px = 250.0;
  c.cx_px = 172.6;
  c.cy_px = 130.3;
  const Pose T_beside_this{so3::exp(Eigen::Vector3d{0.004, 0.012, -0.006}),
                           Eigen::Vector3d{0.04, 0.001, -0.002}};
  c.T_body_cam = beside.T_body_cam * T_beside_this;
  return c;
}

void set_daylight(SimulationOptions& options, Daylight daylight) noexcept {
  // As a sensor's automatic would have it. The parts of a longer exposure stay as close together,
  // or a blur would be a row of ghosts.
  const FrameOptions usual;
  const auto use = [&](double gain, double exposure_s, double noise_grey, int blur_samples) {
    options.frames.gain = gain;
    options.frames.exposure_s = exposure_s;
    options.frames.noise_grey = noise_grey;
    options.frames.blur_samples = blur_samples;
  };
  options.daylight = daylight;
  switch (daylight) {
    case Daylight::kDay:
      return use(usual.gain, usual.exposure_s, usual.noise_grey, usual.blur_samples);
    case Daylight::kDim: return use(5.0, 0.010, 2.5, 9);
    case Daylight::kNight: return use(14.0, 0.020, 4.0, 19);
  }
}

namespace {

SimulationOptions outdoors(WorldKind world, MotionKind motion, MovingLevel moving) noexcept {
  SimulationOptions options;
  options.camera = davis240c_camera();
  options.world = world;
  options.motion = motion;
  options.moving = moving;
  options.duration_s = 10.0;
  return options;
}

}  // namespace

std::optional<SimulationOptions> preset(std::string_view name) noexcept {
  SimulationOptions options;
  options.camera = davis240c_camera();
  if (name == "room") return options;
  if (name == "demo") {
    options = outdoors(WorldKind::kCarPark, MotionKind::kDrone, MovingLevel::kMid);
    options.duration_s = 6.0;
    return options;
  }
  if (name == "car_park")
    return outdoors(WorldKind::kCarPark, MotionKind::kDrone, MovingLevel::kHigh);
  if (name == "street" || name == "night") {
    options = outdoors(WorldKind::kStreet, MotionKind::kCar, MovingLevel::kMid);
    if (name == "night") set_daylight(options, Daylight::kNight);
    return options;
  }
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
  if (name == "hand") {
    options.motion = MotionKind::kHandheld;
    options.duration_s = 10.0;
    return options;
  }
  return std::nullopt;
}

double brightness(const FaultOptions& f, double t_s) noexcept {
  double factor = 1.0;
  if (f.flicker_hz > 0.0)
    factor += f.flicker_depth * std::sin(2.0 * std::numbers::pi * f.flicker_hz * t_s);
  constexpr double kFlash = 4.0;
  if (f.flash_at_s >= 0.0 && t_s >= f.flash_at_s && t_s < f.flash_at_s + f.flash_length_s)
    factor *= kFlash;
  return factor;
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
  if (!(o.frames.gain >= 0.1 && o.frames.gain <= 100))
    return {"frames.gain", "must be in [0.1, 100]"};
  if (!(o.frames.noise_grey >= 0)) return {"frames.noise_grey", "must be >= 0"};
  const EventOptions& e = o.events;
  if (!(e.threshold >= 0.05 && e.threshold <= 1))
    return {"events.threshold", "must be in [0.05, 1]"};
  if (!(e.mismatch >= 0 && e.mismatch <= 0.3)) return {"events.mismatch", "must be in [0, 0.3]"};
  if (!(e.refractory_s >= 0 && e.refractory_s <= 0.01))
    return {"events.refractory_s", "must be in [0, 0.01]"};
  if (!(e.noise_rate_hz >= 0 && e.noise_rate_hz <= 100))
    return {"events.noise_rate_hz", "must be in [0, 100]"};
  if (!(e.leak_rate_hz >= 0 && e.leak_rate_hz <= 10))
    return {"events.leak_rate_hz", "must be in [0, 10]"};
  if (!(e.bandwidth_hz >= 1 && e.bandwidth_hz <= 1e5))
    return {"events.bandwidth_hz", "must be in [1, 1e5]"};
  if (!(e.hot_share >= 0 && e.hot_share <= 0.1)) return {"events.hot_share", "must be in [0, 0.1]"};
  if (!(e.hot_rate_hz >= 0 && e.hot_rate_hz <= 1e4))
    return {"events.hot_rate_hz", "must be in [0, 1e4]"};
  if (!(e.max_step_s >= 1e-4 && e.max_step_s <= 0.02))
    return {"events.max_step_s", "must be in [0.0001, 0.02]"};
  if (!(e.max_motion_px >= 0.05 && e.max_motion_px <= 2))
    return {"events.max_motion_px", "must be in [0.05, 2]"};
  return {};
}

ConfigIssue check_camera(const CameraCalibration& c) noexcept {
  // The EVT3 format addresses 11 bits; a vector word group spans 32 pixels.
  if (!(c.width_px >= 32 && c.width_px <= 2048 && c.height_px >= 16 && c.height_px <= 2048))
    return {"camera.resolution", "must be from 32x16 to 2048x2048"};
  if (!(c.fx_px > 0 && c.fy_px > 0)) return {"camera.intrinsics", "must be > 0"};
  return {};
}

ConfigIssue check_faults(const FaultOptions& f) noexcept {
  if (!(std::abs(f.camera_late_s) <= 0.2))
    return {"faults.camera_late", "must be in [-0.2, 0.2] s"};
  if (!(std::abs(f.imu_drift_ppm) <= 1000))
    return {"faults.imu_drift", "must be in [-1000, 1000] ppm"};
  if (!(f.imu_gap_at_s >= 0 && f.imu_gap_s >= 0)) return {"faults.imu_gap", "must be >= 0"};
  if (!(f.dropped_share >= 0 && f.dropped_share <= 0.9))
    return {"faults.dropped_frames", "must be in [0, 0.9]"};
  if (!(f.flicker_hz >= 0 && f.flicker_hz <= 500 && f.flicker_depth >= 0 && f.flicker_depth <= 0.9))
    return {"faults.flicker", "must be in [0, 500] Hz with a depth in [0, 0.9]"};
  if (!(f.flash_length_s >= 0.001 && f.flash_length_s <= 1))
    return {"faults.flash", "must last [0.001, 1] s"};
  return {};
}

}  // namespace

ConfigIssue check(const SimulationOptions& o) noexcept {
  if (!(o.duration_s >= 0.1 && o.duration_s <= 600)) return {"duration", "must be in [0.1, 600] s"};
  if (!(o.scale >= 0.5 && o.scale <= 10)) return {"scale", "must be in [0.5, 10]"};
  if (!(o.pace >= 0.1 && o.pace <= 2)) return {"pace", "must be in [0.1, 2]"};
  if (!(o.speed_mps >= 1 && o.speed_mps <= 20)) return {"speed", "must be in [1, 20] m/s"};
  if (!(o.still_s >= 0 && o.still_s <= 60)) return {"still_s", "must be in [0, 60]"};
  if (!(o.bus.at_s <= 600 && o.bus.stand_s >= 0 && o.bus.stand_s <= 600))
    return {"bus.time", "must come and stand within 600 s"};
  if (!(o.bus.away_m >= 1 && o.bus.away_m <= 20)) return {"bus.away", "must be in [1, 20] m away"};
  for (const CameraCalibration* camera : {&o.camera, &o.camera_of_events()})
    if (const ConfigIssue issue = check_camera(*camera); issue.key != nullptr) return issue;
  if (const ConfigIssue issue = check_faults(o.faults); issue.key != nullptr) return issue;
  return check_sensors(o);
}

}  // namespace pled::sim
