#pragma once

#include <cstdint>
#include <vector>

#include "pled_vins/sim/options.hpp"
#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/renderer.hpp"

namespace pled::sim {

/// One frame as the sensor gives it, with its label.
struct Frame {
  std::vector<std::uint8_t> grey;       ///< row-major
  std::vector<std::uint8_t> mask;       ///< 255: shows something that moves at mid-exposure
  std::vector<std::uint16_t> depth_mm;  ///< z of each pixel; 0: farther than 65.5 m
};

/// The frame of an exposure whose middle is `t_s`: the mean of renders spread over
/// it, linear response, white noise. `index` numbers the frame for the noise.
[[nodiscard]] Frame expose_frame(const World& world, const Renderer& renderer,
                                 const Trajectory& trajectory, const SimulationOptions& options,
                                 double t_s, std::uint64_t index);

}  // namespace pled::sim
