#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "src/apps/simulated_run.hpp"

namespace pled::support {

using apps::SimulatedRun;
using sim::MotionKind;
using sim::PointWorld;
using sim::PointWorldOptions;

/// Root mean squared position error after the best rigid alignment (no scale), metres.
[[nodiscard]] double aligned_rmse_m(const std::vector<Eigen::Vector3d>& estimate,
                                    const std::vector<Eigen::Vector3d>& truth);

/// Runs the whole world. rmse is NaN with fewer than 10 poses.
struct RunFigures {
  double rmse_m = 0;
  double first_pose_s = -1;   ///< after the first frame; -1: never
  double largest_step_m = 0;  ///< between consecutive poses, beyond the true one
  std::size_t poses = 0;
  std::uint32_t resets = 0;
  double weight_static = 0, weight_moving = 0;  ///< mean over points seen from 3 states or more
};
[[nodiscard]] RunFigures run_world(const PointWorld& world, SimulatedRun& run);

}  // namespace pled::support
