#include "tests/support/simulated_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/SVD>

namespace pled::support {

double aligned_rmse_m(const std::vector<Eigen::Vector3d>& estimate,
                      const std::vector<Eigen::Vector3d>& truth) {
  Eigen::Matrix3Xd a(3, static_cast<Eigen::Index>(estimate.size()));
  Eigen::Matrix3Xd b = a;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    a.col(static_cast<Eigen::Index>(i)) = estimate[i];
    b.col(static_cast<Eigen::Index>(i)) = truth[i];
  }
  const Eigen::Matrix4d T = Eigen::umeyama(a, b, false);
  const Eigen::Matrix3Xd moved =
      (T.topLeftCorner<3, 3>() * a).colwise() + T.topRightCorner<3, 1>().eval();
  return std::sqrt((moved - b).squaredNorm() / static_cast<double>(estimate.size()));
}

RunFigures run_world(const PointWorld& world, SimulatedRun& run) {
  RunFigures figures;
  std::vector<Eigen::Vector3d> estimate, truth;
  double static_sum = 0, moving_sum = 0;
  int static_count = 0, moving_count = 0;
  for (std::size_t k = 0; k < world.frames().size(); ++k) {
    const BackendOutput& out = run.step(k);
    figures.resets = out.pose.reset_counter;
    for (const FeatureWeight& w : out.weights) {
      if (w.observations < 3 || std::isnan(w.w)) continue;
      (world.is_moving(w.id) ? moving_sum : static_sum) += w.w;
      ++(world.is_moving(w.id) ? moving_count : static_count);
    }
    if (!out.has_pose) continue;
    const Timestamp t = world.frames()[k].t;
    if (estimate.empty()) figures.first_pose_s = (t - world.frames()[0].t).seconds();
    estimate.emplace_back(out.pose.p_world_body_m.data());
    truth.push_back(world.truth(t).p_wb);
    if (estimate.size() < 2) continue;
    const std::size_t n = estimate.size();
    const double step = (estimate[n - 1] - estimate[n - 2]).norm();
    const double true_step = (truth[n - 1] - truth[n - 2]).norm();
    figures.largest_step_m = std::max(figures.largest_step_m, step - true_step);
  }
  figures.poses = estimate.size();
  figures.weight_static = static_count ? static_sum / static_count : 0;
  figures.weight_moving = moving_count ? moving_sum / moving_count : 0;
  figures.rmse_m = estimate.size() < 10 ? std::numeric_limits<double>::quiet_NaN()
                                        : aligned_rmse_m(estimate, truth);
  return figures;
}

}  // namespace pled::support
