#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "pled_vins/core/config_issue.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/sim/motion_kind.hpp"

namespace pled::sim {

/// Where it happens.
enum class WorldKind : std::uint8_t { kRoom, kCarPark, kStreet };

/// How much moves by itself; the static part is the same at every level.
enum class MovingLevel : std::uint8_t { kNone, kLow, kMid, kHigh };

enum class Daylight : std::uint8_t { kDay, kDim, kNight };

/// How everything looks.
enum class Surfaces : std::uint8_t {
  kUsual,    ///< as what it is: walls, houses, cars
  kPebbles,  ///< round spots, and nothing stands about: corners, but hardly a straight edge
  kStripes,  ///< stripes on everything, patches of them in all directions: edges without end
};

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
  double gain = 1.0;          ///< grey = 255 gain radiance, 0.1 ... 100
};

/// The event sensor: an event at each crossing of the log intensity.
struct EventOptions {
  double threshold = 0.2;       ///< log-intensity step of ON and OFF events, 0.05 ... 1
  double mismatch = 0.04;       ///< sigma of a pixel's threshold as a share of it, 0 ... 0.3
  double refractory_s = 50e-6;  ///< a pixel rests this long after an event, 0 ... 0.01
  double noise_rate_hz = 0.1;   ///< spurious events of a pixel per second in the dark, a quarter of
                                ///< it in full light, 0 ... 100
  double leak_rate_hz = 0.1;    ///< ON events of a resting pixel per second, 0 ... 10
  double bandwidth_hz = 300.0;  ///< of the photoreceptor at full light; less in the dark, 1 ... 1e5
  double hot_share = 0.0002;    ///< of the pixels that fire by themselves, 0 ... 0.1
  double hot_rate_hz = 200.0;   ///< of such a pixel, 0 ... 1e4
  double max_step_s = 3e-3;     ///< longest time between two renders, 1e-4 ... 0.02
  double max_motion_px = 0.5;   ///< image motion allowed between two renders, 0.05 ... 2
};

/// A bus, 11 m long and 3 m high, that drives up from the right at 8 m/s, across what the rig looks
/// at, and away to the left. It goes through what is in its way. From 2 m it fills the view.
struct BusOptions {
  double at_s = -1.0;    ///< its middle is before the rig; negative: no bus, at most 600
  double stand_s = 0.0;  ///< stands there for so long, 0 ... 600; 0: drives by without stopping
  double away_m = 2.0;   ///< its side from the rig where that comes nearest, 1 ... 20

  [[nodiscard]] bool comes() const noexcept { return at_s >= 0.0; }
};

/// What goes wrong, on request. All off.
struct FaultOptions {
  double camera_late_s = 0.0;    ///< frames and events are stamped so much too late, -0.2 ... 0.2;
                                 ///< the calibration does not know
  double imu_drift_ppm = 0.0;    ///< its clock runs fast by this, -1000 ... 1000
  double imu_gap_at_s = 0.0;     ///< no inertial samples from here ...
  double imu_gap_s = 0.0;        ///< ... for this long; 0: no gap
  double dropped_share = 0.0;    ///< of the frames, at random, 0 ... 0.9
  double flicker_hz = 0.0;       ///< of the light, 0 ... 500; 0: none
  double flicker_depth = 0.2;    ///< its amplitude as a share of the light, 0 ... 0.9
  double flash_at_s = -1.0;      ///< a flash that makes every pixel fire; negative: none
  double flash_length_s = 0.02;  ///< 0.001 ... 1
};

/// Factor of all light at `t_s`.
[[nodiscard]] double brightness(const FaultOptions& faults, double t_s) noexcept;

/// Everything that decides a recording's bytes.
struct SimulationOptions {
  std::uint64_t seed = 1;
  double duration_s = 8.0;  ///< 0.1 ... 600
  MovingLevel moving = MovingLevel::kLow;
  StartKind start = StartKind::kMoving;
  WorldKind world = WorldKind::kRoom;
  Surfaces surfaces = Surfaces::kUsual;
  BusOptions bus;
  Daylight daylight = Daylight::kDay;
  MotionKind motion = MotionKind::kDrone;
  double speed_mps = 5.0;    ///< of a car, 1 ... 20
  std::string path_file;     ///< TUM trajectory to follow instead of a made one; empty: none
  double scale = 1.0;        ///< size of the room and of the flight through it, 0.5 ... 10
  double pace = 1.0;         ///< tempo of the flight, 0.1 ... 2
  double still_s = 2.0;      ///< standing still before the flight when start is kStill, 0 ... 60
  CameraCalibration camera;  ///< of the frames, and of the events unless they have their own
  std::optional<CameraCalibration> event_camera;
  bool with_depth = false;   ///< write a depth picture with each frame
  bool text_events = false;  ///< events.txt instead of events.raw
  ImuOptions imu;
  FrameOptions frames;
  EventOptions events;
  FaultOptions faults;

  [[nodiscard]] const CameraCalibration& camera_of_events() const noexcept {
    return event_camera ? *event_camera : camera;
  }
};

/// A DAVIS240C with its lens (radtan), turned a degree and shifted 2 cm against the body.
[[nodiscard]] CameraCalibration davis240c_camera() noexcept;

/// A camera 4 cm to the right of `beside`, with more pixels and a lens without distortion.
[[nodiscard]] CameraCalibration camera_beside(const CameraCalibration& beside) noexcept;

/// Ready-made options by name, nullopt for an unknown name:
///   demo      6 s through a car park: cars cross, come closer, stop and start, people walk
///   room      8 s through a room, one person-sized box walks by, in motion from the first sample
///   test      4 s through a room, nothing moves
///   hall      8 s, nothing moves, a room five times as large flown at about 2 m/s
///   still     a room with nothing moving, standing still for the first 2 s
///   hand      10 s through a room by an aggressive hand: turns up to 4 rad/s
///   car_park  10 s through a car park, cars and people of every kind
///   street    10 s of driving along a street at 5 m/s
///   night     the same by night
[[nodiscard]] std::optional<SimulationOptions> preset(std::string_view name) noexcept;

/// Names that preset() knows.
inline constexpr std::array<std::string_view, 9> kPresetNames{
    "demo", "test", "room", "hall", "still", "hand", "car_park", "street", "night"};

/// Light, gain, exposure and noise as a sensor's automatic would set them.
void set_daylight(SimulationOptions& options, Daylight daylight) noexcept;

/// The first option out of its range.
[[nodiscard]] ConfigIssue check(const SimulationOptions& options) noexcept;

}  // namespace pled::sim
