#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <Eigen/Core>

#include "pled_vins/core/config_issue.hpp"
#include "pled_vins/geometry/camera.hpp"

namespace pled::sim {

/// How much of the view moves by itself.
enum class MovingLevel : std::uint8_t { kNone, kLow, kHigh };

/// The first seconds of the flight: already moving, or standing still before it begins.
enum class StartKind : std::uint8_t { kMoving, kStill };

/// The inertial sensor. All zero: the truth.
struct ImuOptions {
  ImuNoise noise{.accel_density = 0.002,
                 .accel_walk = 0.003,
                 .gyro_density = 0.00017,
                 .gyro_walk = 0.00002,
                 .rate_hz = 200.0};
  double gyro_bias_radps = 0.01;  ///< length of the constant bias, >= 0; direction by seed
  double accel_bias_mps2 = 0.05;  ///< the same for the accelerometer, >= 0
  bool with_noise = true;         ///< false: neither noise nor biases
};

/// The frame sensor.
struct FrameOptions {
  double rate_hz = 20.0;      ///< 1 ... 200
  double exposure_s = 0.005;  ///< 0 ... 1 / rate; the stamp is its middle
  int blur_samples = 5;       ///< renders averaged over the exposure: odd, 1 ... 63
  double noise_grey = 1.5;    ///< sigma of the pixel noise, grey levels, >= 0
};

/// The event sensor: an event at each crossing of the log intensity.
struct EventOptions {
  double threshold = 0.2;       ///< log-intensity step of ON and OFF events, 0.05 ... 1
  double mismatch = 0.04;       ///< sigma of a pixel's threshold as a share of it, 0 ... 0.3
  double refractory_s = 50e-6;  ///< a pixel rests this long after an event, 0 ... 0.01
  double noise_rate_hz = 0.1;   ///< spurious events of a pixel per second, 0 ... 100
  double max_step_s = 3e-3;     ///< longest time between two renders, 1e-4 ... 0.02
  double max_motion_px = 0.5;   ///< image motion allowed between two renders, 0.05 ... 2
};

/// Everything that decides a recording's bytes.
struct SimulationOptions {
  std::uint64_t seed = 1;
  double duration_s = 8.0;  ///< 0.1 ... 600
  MovingLevel moving = MovingLevel::kLow;
  StartKind start = StartKind::kMoving;
  double scale = 1.0;    ///< size of the room and of the flight through it, 0.5 ... 10
  double pace = 1.0;     ///< tempo of the flight, 0.1 ... 2
  double still_s = 2.0;  ///< standing still before the flight when start is kStill, 0 ... 60
  CameraCalibration camera;
  ImuOptions imu;
  FrameOptions frames;
  EventOptions events;
};

/// A DAVIS240C with its lens (radtan), turned a degree and shifted 2 cm against the body.
[[nodiscard]] CameraCalibration davis240c_camera() noexcept;

/// Ready-made options by name, nullopt for an unknown name:
///   demo   8 s, one person-sized box walks by, in motion from the first sample
///   test   4 s, nothing moves
///   hall   8 s, nothing moves, a room five times as large flown at about 2 m/s
///   still  as demo with nothing moving, standing still for the first 2 s
[[nodiscard]] std::optional<SimulationOptions> preset(std::string_view name) noexcept;

/// Names that preset() knows, for help texts.
inline constexpr std::string_view kPresetNames = "demo, test, hall, still";

/// The first option out of its range.
[[nodiscard]] ConfigIssue check(const SimulationOptions& options) noexcept;

}  // namespace pled::sim
