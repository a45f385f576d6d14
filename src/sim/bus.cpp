#include "src/sim/bus.hpp"

#include <algorithm>
#include <cmath>

namespace pled::sim {
namespace {

const Eigen::Vector3d kHalf_m{5.5, 1.25, 1.45};
constexpr double kClearance_m = 0.15;
constexpr double kSpeed_mps = 8.0;
constexpr double kRamp_s = 2.5;
constexpr double kPassing_s = 2.0;  ///< before and after: in view, or about to be
constexpr double kAway_s = 60.0;    ///< it has long left when it would stop again

/// The level direction in which the rig looks; ahead in the world when it looks up or down.
Eigen::Vector3d level_sight(const Pose& T_world_body) {
  Eigen::Vector3d sight = T_world_body.q * Eigen::Vector3d::UnitZ();
  sight.z() = 0.0;
  if (!(sight.norm() > 0.1)) return Eigen::Vector3d::UnitX();
  return sight.normalized();
}

}  // namespace

Box make_bus(const BusOptions& options, const Trajectory& trajectory) {
  const Pose met = trajectory.at(options.at_s).T_world_body;
  const Eigen::Vector3d sight = level_sight(met);
  double ahead_m = 0.0;
  const double until_s = options.at_s + options.stand_s + kPassing_s;
  for (double t_s = std::max(0.0, options.at_s - kPassing_s); t_s < until_s; t_s += 0.02)
    ahead_m = std::max(ahead_m, sight.dot(trajectory.at(t_s).T_world_body.p - met.p));

  const Eigen::Vector3d left = Eigen::Vector3d::UnitZ().cross(sight);
  Eigen::Vector3d centre_m = met.p + (ahead_m + options.away_m + kHalf_m.y()) * sight;
  centre_m.z() = kClearance_m + kHalf_m.z();
  Box bus = box_at(centre_m, kHalf_m, std::atan2(left.y(), left.x()));
  bus.finish = {Finish::kCarEnd,  Finish::kCarEnd, Finish::kBusSide,
                Finish::kBusSide, Finish::kCarTop, Finish::kCarTop};
  bus.texel_m = 0.01;
  bus.drive.direction = left;
  bus.drive.speed_mps = kSpeed_mps;
  bus.drive.offset_m = -kSpeed_mps * options.at_s;
  if (options.stand_s > 0.0) {
    bus.drive.drive_s = options.at_s + kAway_s;
    bus.drive.stand_s = options.stand_s;
    bus.drive.ramp_s = kRamp_s;
    bus.drive.phase_s = kAway_s;  // its first drive ends when it is before the rig
    bus.drive.offset_m = -kSpeed_mps * (bus.drive.drive_s - kRamp_s);
  }
  return bus;
}

}  // namespace pled::sim
