#pragma once

#include <vector>

#include "src/sim/random.hpp"
#include "src/sim/world.hpp"

namespace pled::sim {

/// Appends a car, two boxes: its middle on the ground at (x, y), nose along `yaw_rad`, driving by
/// `drive` (default: parked).
void add_car(std::vector<Box>& boxes, double x_m, double y_m, double yaw_rad, Random& random,
             const DrivePath& drive = {});

/// The same for a delivery van, one box as high as the flight, with a lettered side.
void add_van(std::vector<Box>& boxes, double x_m, double y_m, double yaw_rad, Random& random,
             const DrivePath& drive);

/// Appends a person who walks to and fro over `reach_m` to either side of (x, y) once in
/// `period_s`.
void add_person(std::vector<Box>& boxes, double x_m, double y_m, const Eigen::Vector2d& reach_m,
                double period_s, Random& random);

/// The houses, the ground and the sky around everything: a box 0 of the given half size, standing
/// on z = 0.
[[nodiscard]] Box make_surroundings(const Eigen::Vector2d& centre_m, const Eigen::Vector3d& half_m);

}  // namespace pled::sim
