#pragma once

#include <cstddef>
#include <cstdint>

#include "pled_vins/backend/start.hpp"
#include "pled_vins/sim/point_world.hpp"

namespace pled::support {

using sim::MotionKind;
using sim::PointWorld;
using sim::PointWorldOptions;
using sim::SmoothMotion;

/// The default settings as the start sees them: with the point noise assumed until then.
[[nodiscard]] BackendConfig start_config();

/// The inertial history as it is when the frame at `until` arrives (0.02 s later).
void fill_history(const PointWorld& world, Timestamp until, ImuHistory& imu);

/// Frames `first` ... of `world` over `span_s`, thinned evenly to what a start takes.
[[nodiscard]] StartFrames start_frames(const PointWorld& world, std::size_t first, double span_s);

/// Gives `share` of the points to one rigid cluster in one part of the image that moves with
/// `speed_mps` in a seeded direction across the view, and shows it in the frames.
void add_cluster(const PointWorld& world, double share, double speed_mps, std::uint64_t seed,
                 StartFrames& frames);

/// How far a guess is from the truth.
struct StartError {
  double scale = 0;         ///< size of the path over the true one, minus 1
  double position_m = 0;    ///< of the last state, in the first body frame
  double velocity_mps = 0;  ///< of the last state, body frame
  double gravity_rad = 0;   ///< angle between "down", body frame, last state
  double gyro_bias_radps = 0;
};
[[nodiscard]] StartError start_error(const PointWorld& world, const StartGuess& guess);

}  // namespace pled::support
