#include <memory>

#include <Eigen/Cholesky>
#include <doctest/doctest.h>

#include "pled_vins/backend/marginalisation.hpp"
#include "pled_vins/backend/solvers.hpp"
#include "tests/support/flown_window.hpp"

namespace pled {

using support::disturb;
using support::FreeWindow;
using support::GaugedWindow;
using support::leak;
using support::null_space;

TEST_SUITE("backend.window") {
  TEST_CASE("no factor and no prior knows position or heading when first estimates are used") {
    FreeWindow f;
    support::add_lines(f, 20, 7);
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
    support::add_lines(f, 20, 8);
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

  TEST_CASE("splitting a point or line never claims more than keeping it whole") {
    GaugedWindow f;
    support::add_lines(f, 20, 9);
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

  TEST_CASE("the solvers' optimum is a stationary point of the normal equations") {
    for (const SolverKind kind : {SolverKind::kFixed, SolverKind::kCeres}) {
      CAPTURE(static_cast<int>(kind));
      GaugedWindow f;
      support::add_lines(f, 20, 10);
      disturb(*f.window, 5);
      auto equations = std::make_unique<NormalEquations>();
      // Newton decrement: by how much, in sigmas squared, the equations would still move.
      const auto decrement = [&] {
        equations->add_all(*f.window, f.rig, f.settings);
        const Eigen::VectorXd b = equations->b();
        return b.dot(Eigen::MatrixXd(equations->H()).ldlt().solve(b));
      };
      CHECK(decrement() > 100.0);
      const auto solver = make_solver(kind);
      const SolveSummary summary = solver->solve({*f.window, f.rig, f.settings},
                                                 {.max_iterations = 30, .hold_weights = true});
      CHECK(summary.ok);
      CHECK(summary.final_cost < summary.initial_cost);
      CHECK(decrement() < 0.5);
    }
  }

  TEST_CASE("not one iteration more than allowed is made") {
    for (const SolverKind kind : {SolverKind::kFixed, SolverKind::kCeres}) {
      CAPTURE(static_cast<int>(kind));
      GaugedWindow f;
      disturb(*f.window, 6);
      const auto solver = make_solver(kind);
      const SolveSummary summary =
          solver->solve({*f.window, f.rig, f.settings}, {.max_iterations = 2});
      CHECK(summary.iterations <= 2);
      CHECK(summary.iterations > 0);
    }
  }
}

}  // namespace pled
