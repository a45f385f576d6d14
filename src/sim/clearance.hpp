#pragma once

#include <optional>

#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/world.hpp"

namespace pled::sim {

/// When the body first comes closer than 10 cm to something that stands, or leaves the world,
/// within `duration_s`; nothing when it never does. What moves by itself does not count.
[[nodiscard]] std::optional<double> first_contact_s(const World& world,
                                                    const Trajectory& trajectory,
                                                    double duration_s) noexcept;

}  // namespace pled::sim
