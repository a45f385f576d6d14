#include "tests/support/simulated_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "pled_vins/backend/ceres_solver.hpp"

namespace pled::support {

SimulatedRun::SimulatedRun(const PointWorld& world, const BackendConfig& config)
    : world_(world),
      solver_(make_ceres_solver()),
      backend_(std::make_unique<Backend>(config, world.rig(), *solver_)),
      imu_(std::make_unique<ImuHistory>()),
      output_(std::make_unique<BackendOutput>()) {}

SimulatedRun::~SimulatedRun() = default;

const BackendOutput& SimulatedRun::step(std::size_t k) {
  const FrameMeasurement& frame = world_.frames()[k];
  for (; next_imu_ < world_.imu().size(); ++next_imu_) {
    const ImuSample& sample = world_.imu()[next_imu_];
    if (sample.t > frame.t + Duration{6000}) break;
    if (!lost(sample)) imu_->add(sample);
  }
  backend_->process(frame, *imu_, *output_);
  return *output_;
}

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

namespace {

/// Quantile of chi^2 by Wilson and Hilferty's cube-root approximation; better than 0.1 % at the
/// degrees of freedom used here. z: quantile of the standard normal.
double chi_squared_quantile(double dof, double z) {
  const double a = 2.0 / (9.0 * dof);
  return dof * std::pow(1.0 - a + z * std::sqrt(a), 3.0);
}

Vector15d start_sigma() {
  Vector15d sigma;
  sigma << Eigen::Vector3d::Constant(1e-3), Eigen::Vector3d::Constant(0.01),
      Eigen::Vector3d::Constant(0.05), Eigen::Vector3d::Constant(0.002),
      Eigen::Vector3d::Constant(0.03);
  return sigma;
}

double gaussian(std::mt19937_64& random) {
  const auto unit = [&random] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  const double u = 1.0 - unit();
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * unit());
}

}  // namespace

Consistency check_consistency(int runs, double duration_s, std::uint64_t first_seed) {
  Consistency out;
  out.runs = runs;
  for (int run = 0; run < runs; ++run) {
    PointWorldOptions options;
    options.seed = first_seed + static_cast<std::uint64_t>(run);
    options.duration_s = duration_s;
    const PointWorld world(options);
    BackendConfig config;
    config.point_sigma_px = options.pixel_sigma;
    SimulatedRun simulated(world, config);
    std::mt19937_64 random(options.seed * 31 + 7);
    Vector15d disturbance = start_sigma();
    for (int i = 0; i < 15; ++i) disturbance[i] *= gaussian(random);
    const NavState truth = world.truth(world.frames()[0].t);
    NavState start = box_plus(truth, disturbance);
    start.t = truth.t;
    simulated.backend().start_from(start, start_sigma());
    out.nees.resize(world.frames().size(), 0.0);
    for (std::size_t k = 0; k < world.frames().size(); ++k) {
      (void)simulated.step(k);
      const std::optional<Matrix6d> covariance = simulated.backend().newest_pose_covariance();
      const NavState now = world.truth(world.frames()[k].t);
      const Vector15d error = box_minus(now, simulated.backend().window().newest().x);
      const Vector6d e = error.head<6>();
      // Without a covariance the run counts as wholly inconsistent, not as absent.
      out.nees[k] += (covariance ? e.dot(covariance->ldlt().solve(e)) : 1e6) / runs;
    }
  }
  constexpr double kNormal975 = 1.959964;
  out.lower = chi_squared_quantile(6.0 * runs, -kNormal975) / runs;
  out.upper = chi_squared_quantile(6.0 * runs, kNormal975) / runs;
  for (const double nees : out.nees) {
    out.mean += nees / static_cast<double>(out.nees.size());
    out.share_inside +=
        (nees >= out.lower && nees <= out.upper ? 1.0 : 0.0) / static_cast<double>(out.nees.size());
  }
  return out;
}

}  // namespace pled::support
