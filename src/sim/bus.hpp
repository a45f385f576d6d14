#pragma once

#include "pled_vins/sim/options.hpp"
#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/world.hpp"

namespace pled::sim {

/// The bus that `options` ask for, not painted: across the level part of the rig's line of sight at
/// its time, from right to left. The rig never comes nearer than `away_m` while it passes or
/// stands.
[[nodiscard]] Box make_bus(const BusOptions& options, const Trajectory& trajectory);

}  // namespace pled::sim
