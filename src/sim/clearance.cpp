#include "src/sim/clearance.hpp"

#include <algorithm>

namespace pled::sim {
namespace {

constexpr double kClearance_m = 0.1;
constexpr double kStep_s = 0.02;

bool touches(const Box& box, const Eigen::Vector3d& p_world_m) noexcept {
  const Eigen::Array3d from_middle =
      (box.T_world_rest.inverse() * p_world_m).array().abs();  // in the box's axes
  if (box.seen_from_inside) return (from_middle > box.half_m.array() - kClearance_m).any();
  return (from_middle < box.half_m.array() + kClearance_m).all();
}

}  // namespace

std::optional<double> first_contact_s(const World& world, const Trajectory& trajectory,
                                      double duration_s) noexcept {
  const auto steps = static_cast<long>(duration_s / kStep_s) + 1;
  for (long k = 0; k <= steps; ++k) {
    const double t_s = std::min(static_cast<double>(k) * kStep_s, duration_s);
    const Eigen::Vector3d p_world_m = trajectory.at(t_s).T_world_body.p;
    for (const Box& box : world.boxes)
      if (!box.can_move() && touches(box, p_world_m)) return t_s;
  }
  return std::nullopt;
}

}  // namespace pled::sim
