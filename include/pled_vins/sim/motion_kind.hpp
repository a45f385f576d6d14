#pragma once

#include <cstdint>

namespace pled::sim {

/// How the rig moves.
enum class MotionKind : std::uint8_t {
  kStill,     ///< stands
  kDrone,     ///< a few metres to and fro, gentle turns
  kHandheld,  ///< aggressive: turns up to 4 rad/s
  kCar,       ///< planar, forward, heading along the path
  kCreep,     ///< straight on and to the side at constant speed, without turning; of points alone
  kPan,       ///< on the spot, turns about the vertical at 3 deg/s; of points alone
};

}  // namespace pled::sim
