#include <memory>
#include <random>

#include <Eigen/Cholesky>
#include <doctest/doctest.h>

#include "pled_vins/backend/ceres_solver.hpp"
#include "pled_vins/backend/marginalisation.hpp"
#include "tests/support/simulated_run.hpp"

namespace pled {
namespace {

using support::PointWorld;
using support::PointWorldOptions;
using support::SimulatedRun;

/// A full window of a drone's flight, before anything was marginalised, without the belief
/// about its first state: nothing fixes position and heading.
struct FreeWindow {
  FreeWindow() {
    PointWorldOptions options;
    options.duration_s = 0.55;
    const PointWorld world(options);
    rig = world.rig();
    BackendConfig config;
    config.point_sigma_px = options.pixel_sigma;
    settings = make_factor_settings(config, rig);
    SimulatedRun run(world, config);
    NavState truth = world.truth(world.frames()[0].t);
    run.backend().start_from(truth, Vector15d::Constant(0.01));
    for (std::size_t k = 0; k < 10; ++k) REQUIRE(run.step(k).has_pose);
    window = std::make_unique<SlidingWindow>(run.backend().window());
    REQUIRE(window->size() == 10);
    window->state(0).prior.reset();
    for (Landmark& l : window->landmarks) l.weak_depth = false;
  }
  std::unique_ptr<SlidingWindow> window;
  RigCalibration rig;
  FactorSettings settings;
};

/// The same with its first state held.
struct GaugedWindow : FreeWindow {
  GaugedWindow() {
    StatePrior gauge;
    gauge.mean = window->state(0).x;
    gauge.sqrt_information = Matrix15d::Identity() * 100.0;
    window->state(0).prior = gauge;
  }
};

/// The four directions that no measurement tells: three shifts and a turn about gravity, at the
/// states' linearisation points.
Eigen::MatrixXd null_space(const SlidingWindow& window, int dim, bool first_estimates) {
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(dim, 4);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  for (std::size_t i = 0; i < window.size(); ++i) {
    const NavState& x = window.state(i).linearisation(first_estimates);
    const int row = static_cast<int>(i) * kStateDim;
    N.block<3, 3>(row, 0).setIdentity();
    N.block<3, 1>(row, 3) = up.cross(x.p_wb);
    N.block<3, 1>(row + 3, 3) = x.q_wb.conjugate() * up;
    N.block<3, 1>(row + 6, 3) = up.cross(x.v_wb);
  }
  return N;
}

/// How much the equations claim to know along each direction, against what they know in all.
double leak(NormalEquations& equations, const Eigen::MatrixXd& N) {
  double worst = 0;
  for (int k = 0; k < 4; ++k) {
    const Eigen::VectorXd n = N.col(k);
    const double scale = (n.cwiseAbs2().cwiseProduct(equations.H().diagonal())).sum();
    worst = std::max(worst, std::abs(n.dot(equations.H() * n)) / scale);
  }
  return worst;
}

void disturb(SlidingWindow& window, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (std::size_t i = 0; i < window.size(); ++i) {
    Vector15d d;
    for (int k = 0; k < 15; ++k)
      d[k] = 0.02 * (2.0 * static_cast<double>(random() >> 11) * 0x1.0p-53 - 1.0);
    d.tail<6>() *= 0.01;
    const Timestamp t = window.state(i).x.t;
    window.state(i).x = box_plus(window.state(i).x, d);
    window.state(i).x.t = t;
  }
}

}  // namespace

TEST_SUITE("backend.window") {
  TEST_CASE("no factor and no prior knows position or heading when first estimates are used") {
    FreeWindow f;
    auto equations = std::make_unique<NormalEquations>();
    equations->add_all(*f.window, f.rig, f.settings);
    CHECK(leak(*equations, null_space(*f.window, equations->dim(), true)) < 1e-9);

    auto marginaliser = std::make_unique<Marginaliser>();
    REQUIRE(marginaliser->marginalise(*f.window, f.rig, f.settings, 0));
    REQUIRE(f.window->prior.valid);
    equations->reset(*f.window, f.settings);
    equations->add_marginal_prior(*f.window);
    CHECK(leak(*equations, null_space(*f.window, equations->dim(), true)) < 1e-9);

    // The estimate moves on: with Jacobians at the new estimate, knowledge leaks in.
    disturb(*f.window, 3);
    equations->add_all(*f.window, f.rig, f.settings);
    CHECK(leak(*equations, null_space(*f.window, equations->dim(), true)) < 1e-9);
    f.settings.first_estimates = false;
    equations->add_all(*f.window, f.rig, f.settings);
    CHECK(leak(*equations, null_space(*f.window, equations->dim(), false)) > 1e-9);
  }

  TEST_CASE("eliminating the oldest state leaves the covariance of the newest pose as it was") {
    GaugedWindow f;
    auto equations = std::make_unique<NormalEquations>();
    const auto covariance = [&] {
      equations->add_all(*f.window, f.rig, f.settings);
      const Eigen::MatrixXd inverse = Eigen::MatrixXd(equations->H()).inverse();
      return Matrix6d(inverse.block<6, 6>(equations->dim() - 15, equations->dim() - 15));
    };
    const Matrix6d before = covariance();
    auto marginaliser = std::make_unique<Marginaliser>(LivePointRule::kEliminate);
    REQUIRE(marginaliser->marginalise(*f.window, f.rig, f.settings, 0));
    const Matrix6d after = covariance();
    CHECK((after - before).norm() < 1e-5 * before.norm());
  }

  TEST_CASE("splitting a point never claims more than keeping it whole") {
    GaugedWindow f;
    auto equations = std::make_unique<NormalEquations>();
    const auto spread = [&] {
      equations->add_all(*f.window, f.rig, f.settings);
      const Eigen::MatrixXd inverse = Eigen::MatrixXd(equations->H()).inverse();
      return Eigen::VectorXd(inverse.diagonal().tail(15)).eval();
    };
    const Eigen::VectorXd before = spread();
    auto marginaliser = std::make_unique<Marginaliser>(LivePointRule::kSplit);
    REQUIRE(marginaliser->marginalise(*f.window, f.rig, f.settings, 0));
    const Eigen::VectorXd after = spread();
    for (int k = 0; k < 15; ++k) CHECK(after[k] >= before[k] * (1 - 1e-6));
  }

  TEST_CASE("the solver's optimum is a stationary point of the normal equations") {
    GaugedWindow f;
    disturb(*f.window, 5);
    auto equations = std::make_unique<NormalEquations>();
    // Newton decrement: by how much, in sigmas squared, the equations would still move.
    const auto decrement = [&] {
      equations->add_all(*f.window, f.rig, f.settings);
      const Eigen::VectorXd b = equations->b();
      return b.dot(Eigen::MatrixXd(equations->H()).ldlt().solve(b));
    };
    CHECK(decrement() > 100.0);
    const auto solver = make_ceres_solver();
    const SolveSummary summary =
        solver->solve({*f.window, f.rig, f.settings}, {.max_iterations = 30});
    CHECK(summary.ok);
    CHECK(summary.final_cost < summary.initial_cost);
    CHECK(decrement() < 0.5);
  }

  TEST_CASE("not one iteration more than allowed is made") {
    GaugedWindow f;
    disturb(*f.window, 6);
    const auto solver = make_ceres_solver();
    const SolveSummary summary =
        solver->solve({*f.window, f.rig, f.settings}, {.max_iterations = 2});
    CHECK(summary.iterations <= 2);
  }
}

}  // namespace pled
