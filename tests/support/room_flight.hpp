#pragma once

#include <cstdint>

#include "pled_vins/sim/trajectory.hpp"

namespace pled::sim {

/// The flight of the room's presets.
[[nodiscard]] inline SineFlight room_flight(std::uint64_t seed, StartKind start, double still_s) {
  SimulationOptions options;
  options.seed = seed;
  options.start = start;
  options.still_s = still_s;
  return SineFlight(options);
}

}  // namespace pled::sim
