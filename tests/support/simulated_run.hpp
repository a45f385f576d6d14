#pragma once

#include <functional>
#include <memory>

#include "pled_vins/backend/backend.hpp"
#include "pled_vins/imu/imu_history.hpp"
#include "tests/support/point_world.hpp"

namespace pled::support {

/// A back end fed with a simulated world, frame by frame.
class SimulatedRun {
 public:
  SimulatedRun(const PointWorld& world, const BackendConfig& config);
  ~SimulatedRun();

  /// True for inertial samples that never arrive.
  std::function<bool(const ImuSample&)> lost = [](const ImuSample&) { return false; };

  /// Feeds frame k (in order, all of them) with the inertial data up to it.
  const BackendOutput& step(std::size_t k);
  [[nodiscard]] Backend& backend() { return *backend_; }

 private:
  const PointWorld& world_;
  std::unique_ptr<WindowSolver> solver_;
  std::unique_ptr<Backend> backend_;
  std::unique_ptr<ImuHistory> imu_;
  std::unique_ptr<BackendOutput> output_;
  std::size_t next_imu_ = 0;
};

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

/// Normalised estimation error squared of the newest pose (6 dof) over time and runs.
struct Consistency {
  int runs = 0;
  std::vector<double> nees;     ///< mean over the runs at each frame
  double mean = 0;              ///< over runs and time
  double lower = 0, upper = 0;  ///< 95 % of chi^2 with 6 * runs dof, over runs: for one instant
  double share_inside = 0;      ///< of instants
};

/// Runs `runs` static worlds (seeds first_seed ...), each started from the truth disturbed by
/// a known prior; the estimator is told the noise that is simulated.
[[nodiscard]] Consistency check_consistency(int runs, double duration_s, std::uint64_t first_seed);

}  // namespace pled::support
