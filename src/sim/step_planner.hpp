#pragma once

#include "pled_vins/sim/options.hpp"
#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/renderer.hpp"

namespace pled::sim {

/// How long after `t_s` the next render is due, so that nothing of what `view` (the
/// render at t_s) shows moves further than max_motion_px, at most max_step_s. Looks
/// at a grid of pixels, 8 px apart.
[[nodiscard]] double plan_step_s(const World& world, const Renderer& renderer,
                                 const Trajectory& trajectory, const SimulationOptions& options,
                                 const View& view, double t_s);

}  // namespace pled::sim
