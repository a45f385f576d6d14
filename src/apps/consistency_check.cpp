#include "src/apps/consistency_check.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <numbers>
#include <optional>
#include <random>
#include <thread>

#include <Eigen/Cholesky>

#include "pled_vins/sim/point_world.hpp"
#include "src/apps/simulated_run.hpp"

namespace pled::apps {
namespace {

constexpr double kPoseDof = 6.0;
constexpr double kNormal975 = 1.959964;

/// Quantile of chi^2 by Wilson and Hilferty's cube-root approximation; better than 0.1 % at the
/// degrees of freedom used here. z: quantile of the standard normal.
double chi_squared_quantile(double dof, double z) {
  const double a = 2.0 / (9.0 * dof);
  return dof * std::pow(1.0 - a + z * std::sqrt(a), 3.0);
}

/// Of position (m), attitude (rad), velocity (m/s), gyro (rad/s) and accelerometer bias (m/s^2).
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

/// NEES of the newest pose after each frame of one run.
std::vector<double> run_once(std::uint64_t seed, double duration_s) {
  sim::PointWorldOptions options;
  options.seed = seed;
  options.duration_s = duration_s;
  const sim::PointWorld world(options);
  BackendConfig config;
  config.point_sigma_px = options.pixel_sigma;
  SimulatedRun simulated(world, config);
  std::mt19937_64 random(seed * 31 + 7);
  Vector15d disturbance = start_sigma();
  for (int i = 0; i < 15; ++i) disturbance[i] *= gaussian(random);
  const NavState truth = world.truth(world.frames()[0].t);
  NavState start = box_plus(truth, disturbance);
  start.t = truth.t;
  simulated.backend().start_from(start, start_sigma());
  std::vector<double> nees;
  nees.reserve(world.frames().size());
  for (std::size_t k = 0; k < world.frames().size(); ++k) {
    (void)simulated.step(k);
    const std::optional<Matrix6d> covariance = simulated.backend().newest_pose_covariance();
    const NavState now = world.truth(world.frames()[k].t);
    const Vector15d error = box_minus(now, simulated.backend().window().newest().x);
    const Vector6d e = error.head<6>();
    // Without a covariance the run counts as wholly inconsistent, not as absent.
    nees.push_back(covariance ? e.dot(covariance->ldlt().solve(e)) : 1e6);
  }
  return nees;
}

/// All runs, in the order of their seeds, whichever thread made them.
std::vector<std::vector<double>> run_all(const ConsistencyOptions& options,
                                         const std::function<void(int)>& done) {
  std::vector<std::vector<double>> results(static_cast<std::size_t>(options.runs));
  std::atomic<std::size_t> next{0};
  std::mutex reporting;
  int finished = 0;
  const auto work = [&] {
    for (std::size_t i = next.fetch_add(1); i < results.size(); i = next.fetch_add(1)) {
      results[i] = run_once(options.first_seed + i, options.duration_s);
      const std::lock_guard lock(reporting);
      ++finished;
      if (done) done(finished);
    }
  };
  std::vector<std::jthread> others;
  for (int i = 1; i < std::min(options.jobs, options.runs); ++i) others.emplace_back(work);
  work();
  others.clear();  // waits for them
  return results;
}

}  // namespace

Consistency check_consistency(const ConsistencyOptions& options,
                              const std::function<void(int)>& done) {
  Consistency out;
  out.runs = options.runs;
  const double runs = options.runs;
  for (const std::vector<double>& run : run_all(options, done)) {
    out.nees.resize(run.size(), 0.0);
    for (std::size_t k = 0; k < run.size(); ++k) out.nees[k] += run[k] / runs;
  }
  out.lower = chi_squared_quantile(kPoseDof * runs, -kNormal975) / runs;
  out.upper = chi_squared_quantile(kPoseDof * runs, kNormal975) / runs;
  const auto instants = static_cast<double>(out.nees.size());
  for (const double nees : out.nees) {
    out.mean += nees / instants;
    out.share_inside += (nees >= out.lower && nees <= out.upper ? 1.0 : 0.0) / instants;
  }
  return out;
}

}  // namespace pled::apps
