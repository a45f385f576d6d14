#include <cmath>
#include <limits>
#include <memory>

#include <doctest/doctest.h>

#include "pled_vins/backend/feature_loss.hpp"
#include "pled_vins/backend/sights.hpp"
#include "pled_vins/backend/solvers.hpp"
#include "tests/support/flown_window.hpp"

namespace pled {
namespace {

using support::disturb;
using support::FreeWindow;
using support::GaugedWindow;

/// Weights of many sizes, as a flight among traffic leaves them.
void spread_weights(SlidingWindow& window) {
  std::size_t k = 0;
  for (Landmark& landmark : window.landmarks)
    landmark.reliability.w = 0.1 + 0.1 * static_cast<double>(k++ % 10);
  for (LineLandmark& line : window.lines)
    line.reliability.w = 0.1 + 0.1 * static_cast<double>(k++ % 10);
}

/// To the bottom: each call ends early, by its relative tolerance.
SolveSummary solve_well(SolverKind kind, GaugedWindow& f) {
  const auto solver = make_solver(kind);
  SolveSummary summary;
  for (int round = 0; round < 4; ++round)
    summary =
        solver->solve({*f.window, f.rig, f.settings}, {.max_iterations = 50, .hold_weights = true});
  return summary;
}

/// What is to be minimised, by one measure for both.
double cost_of(GaugedWindow& f) {
  return make_solver(SolverKind::kFixed)
      ->solve({*f.window, f.rig, f.settings}, {.max_iterations = 0, .hold_weights = true})
      .final_cost;
}

/// How far apart the states of two windows are, in standard deviations of the whole window.
double sigmas_apart(const GaugedWindow& a, const GaugedWindow& b) {
  auto equations = std::make_unique<NormalEquations>();
  equations->add_all(*a.window, a.rig, a.settings);
  Eigen::VectorXd d = Eigen::VectorXd::Zero(equations->dim());
  for (std::size_t i = 0; i < a.window->size(); ++i)
    d.segment<kStateDim>(static_cast<Eigen::Index>(i) * kStateDim) =
        box_minus(b.window->state(i).x, a.window->state(i).x);
  const RigState& from = a.window->rig_state;
  const RigState& to = b.window->rig_state;
  if (equations->extrinsic_row() >= 0)
    d.segment<kExtrinsicDim>(equations->extrinsic_row()) =
        extrinsic_change(from.T_body_cam, to.T_body_cam);
  if (equations->time_shift_row() >= 0)
    d[equations->time_shift_row()] = to.time_shift_s - from.time_shift_s;
  return std::sqrt(d.dot(equations->H() * d));
}

template <typename Landmarks>
void check_weights(const FreeWindow& f, const Landmarks& landmarks) {
  for (const auto& landmark : landmarks) {
    if (!landmark.in_solver) continue;
    auto again = landmark.reliability;
    weigh(f.settings, squared_sights(*f.window, f.rig, f.settings, landmark).span(), again);
    CHECK(landmark.reliability.w == doctest::Approx(again.w).epsilon(1e-9));
    CHECK(landmark.reliability.w > 0.0);
    CHECK(landmark.reliability.w < 1.0);
  }
}

}  // namespace

TEST_SUITE("backend.solver") {
  TEST_CASE("the fixed solver finds Ceres' optimum, with points, lines, weights and calibration") {
    for (const bool calibrate : {false, true}) {
      for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        CAPTURE(seed);
        CAPTURE(calibrate);
        GaugedWindow a;
        GaugedWindow b;
        for (GaugedWindow* f : {&a, &b}) {
          f->settings.estimate_extrinsic = f->settings.estimate_time_shift = calibrate;
          support::add_lines(*f, 20, seed);
          spread_weights(*f->window);
          disturb(*f->window, seed);
        }
        const SolveSummary ours = solve_well(SolverKind::kFixed, a);
        const SolveSummary theirs = solve_well(SolverKind::kCeres, b);
        REQUIRE(ours.ok);
        REQUIRE(theirs.ok);
        CHECK(cost_of(a) == doctest::Approx(cost_of(b)).epsilon(1e-3));
        // Both end by their relative tolerance, some way along the flat valley of the scale.
        CHECK(sigmas_apart(a, b) < 1.0);
      }
    }
  }

  TEST_CASE("a solve leaves each weight at the minimum of its loss") {
    GaugedWindow f;
    support::add_lines(f, 20, 3);
    f.window->landmarks[0].reliability.temporal = 0.1;
    f.window->lines[0].reliability.temporal = 0.1;
    disturb(*f.window, 4);
    const auto solver = make_solver(SolverKind::kFixed);
    REQUIRE(solver->solve({*f.window, f.rig, f.settings}, {.max_iterations = 8}).ok);
    check_weights(f, f.window->landmarks);
    check_weights(f, f.window->lines);
  }

  TEST_CASE("weights that follow the states come to a lower joint cost than weights that wait") {
    GaugedWindow a;
    GaugedWindow b;
    disturb(*a.window, 5);
    disturb(*b.window, 5);
    const auto ours = make_solver(SolverKind::kFixed)
                          ->solve({*a.window, a.rig, a.settings}, {.max_iterations = 20});
    const auto held =
        make_solver(SolverKind::kFixed)
            ->solve({*b.window, b.rig, b.settings}, {.max_iterations = 20, .hold_weights = true});
    CHECK(ours.final_cost < held.final_cost);
  }

  TEST_CASE("a window that nothing fixes in space is solved all the same, to the same motion") {
    FreeWindow f;
    support::add_lines(f, 10, 6);
    const auto way = [&] {
      const NavState& first = f.window->state(0).x;
      return Eigen::Vector3d(first.q_wb.conjugate() * (f.window->newest().x.p_wb - first.p_wb));
    };
    const Eigen::Vector3d before = way();
    const SolveSummary summary =
        make_solver(SolverKind::kFixed)
            ->solve({*f.window, f.rig, f.settings}, {.max_iterations = 20});
    CHECK(summary.ok);
    CHECK(summary.final_cost < summary.initial_cost);
    CHECK((way() - before).norm() < 0.1 * before.norm());
  }

  TEST_CASE("a window with a value that is not finite is refused and stays as it was") {
    GaugedWindow f;
    disturb(*f.window, 8);
    f.window->landmarks[0].observations[1].xy[0] = std::numeric_limits<double>::quiet_NaN();
    f.window->landmarks[0].in_solver = true;
    const NavState before = f.window->newest().x;
    const SolveSummary summary = make_solver(SolverKind::kFixed)
                                     ->solve({*f.window, f.rig, f.settings}, {.max_iterations = 8});
    CHECK(box_minus(f.window->newest().x, before).norm() == 0.0);
    CHECK_FALSE(summary.ok);
  }

  TEST_CASE("an empty window is refused") {
    GaugedWindow f;
    f.window->clear();
    const SolveSummary summary = make_solver(SolverKind::kFixed)
                                     ->solve({*f.window, f.rig, f.settings}, {.max_iterations = 8});
    CHECK_FALSE(summary.ok);
    CHECK(summary.iterations == 0);
  }
}

}  // namespace pled
