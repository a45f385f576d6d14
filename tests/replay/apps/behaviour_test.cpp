// What the estimator does where others go wrong, from a simulated recording to its poses. Bounds
// come from what a pose is needed for, not from what was measured; messages tell that.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include <doctest/doctest.h>

#include "tests/support/simulated_scene.hpp"

namespace {

using namespace pled::support;
using pled::sim::MotionKind;
using pled::sim::MovingLevel;
using pled::sim::SimulationOptions;
using pled::sim::Surfaces;

constexpr const char* kWithoutLines = "lines:\n  source: none\n";

/// A preset with another length and with nothing that moves by itself.
SimulationOptions calm(const std::string& preset, double duration_s) {
  SimulationOptions options = *pled::sim::preset(preset);
  options.moving = MovingLevel::kNone;
  options.duration_s = duration_s;
  return options;
}

/// A preset with all the traffic or people there are.
SimulationOptions busy(const std::string& preset, std::uint64_t seed, double duration_s) {
  SimulationOptions options = calm(preset, duration_s);
  options.moving = MovingLevel::kHigh;
  options.seed = seed;
  return options;
}

/// Largest distance between any pose from `from_s` on, by the recording's time, and the first of
/// them: all motion there is, for the rig stands.
double drift_m(const Played& played, double from_s) {
  const pled::PositionError* first = nullptr;
  double worst_m = 0.0;
  for (const pled::PositionError& pose : played.evaluation.position_errors) {
    if (static_cast<double>(pose.stamp_ns) * 1e-9 < from_s) continue;
    if (first == nullptr) first = &pose;
    worst_m = std::max(worst_m, (pose.estimate_m - first->estimate_m).norm());
  }
  return first != nullptr ? worst_m : std::nan("");
}

void check_no_reset(const Played& played) {
  CHECK(played.report["resets"] == 0);
  CHECK(played.evaluation.poses > 20);
}

/// A quarter of a second before the recording's end.
std::int64_t end_ns(const SimulationOptions& options) {
  return std::llround(1e9 * (options.duration_s - 0.25));
}

std::string told(const Played& played, double from_s = 1.5) {
  return "rmse " + std::to_string(1e3 * played.evaluation.ate_rmse_m.value_or(std::nan(""))) +
         " mm, at most " + std::to_string(1e3 * played.worst_error_m(from_s)) + " mm; " +
         played.cost();
}

}  // namespace

TEST_SUITE("apps.behaviour") {
  TEST_CASE("standing while traffic passes it does not drift by a centimetre in 20 s") {
    for (const std::string preset : {"street", "car_park"}) {
      CAPTURE(preset);
      SimulationOptions options = busy(preset, 1, 20.5);
      options.motion = MotionKind::kStill;
      const Played played = SimulatedScene("standing", options).play();
      MESSAGE(preset << ": drifted by at most " << 1e3 * drift_m(played, 0.0) << " mm");
      check_no_reset(played);
      CHECK(played.report["initialised_at_s"] < 1.0);
      CHECK(drift_m(played, 0.0) < 0.01);
    }
  }

  TEST_CASE("after a flight it comes to rest within 3 cm and then stays within one") {
    const SimulatedScene scene("stops", busy("room", 1, 26.0),
                               [](double t_s) { return flight_until(4.0, t_s); });
    const Played played = scene.play();
    MESSAGE("drifted by at most " << 1e3 * drift_m(played, 5.5) << " mm, from 2 s later on "
                                  << 1e3 * drift_m(played, 7.5) << " mm; " << told(played));
    check_no_reset(played);
    CHECK(drift_m(played, 5.5) < 0.03);
    CHECK(drift_m(played, 7.5) < 0.01);
  }

  TEST_CASE("a bus that fills the view does not take the estimate with it") {
    for (const MotionKind motion : {MotionKind::kDrone, MotionKind::kStill})
      for (const double stand_s : {0.0, 2.0}) {
        CAPTURE(static_cast<int>(motion));
        CAPTURE(stand_s);
        SimulationOptions options = calm("car_park", 7.0 + stand_s);
        options.motion = motion;
        options.bus = {.at_s = 4.5, .stand_s = stand_s, .away_m = 2.0};
        const Played played = SimulatedScene("bus", options).play();
        MESSAGE(std::string(motion == MotionKind::kDrone ? "flying" : "standing")
                << std::string(stand_s > 0.0 ? ", the bus stops: " : ", the bus drives by: ")
                << told(played, 3.0));
        // Standing, with nothing else to see for 1.5 s, it begins anew in the same place.
        if (motion == MotionKind::kDrone) CHECK(played.report["resets"] == 0);
        CHECK(played.report["resets"] <= 1);
        CHECK(played.evaluation.position_errors.back().stamp_ns > end_ns(options));
        // It drives by with 8 m/s: what believed it for a frame would be 0.4 m off.
        CHECK(played.worst_error_m(3.0) < 0.1);
      }
  }

  TEST_CASE("what parks is believed and what drives off is disbelieved well within a second") {
    for (const std::uint64_t seed : {1U, 2U}) {
      CAPTURE(seed);
      SimulationOptions options = calm("car_park", 8.5);
      options.seed = seed;
      options.bus = {.at_s = 4.5, .stand_s = 2.5, .away_m = 7.0};
      const SimulatedScene scene("parks", options);
      const Played played = scene.play();
      check_no_reset(played);
      for (const bool of_lines : {false, true}) {
        CAPTURE(of_lines);
        const Recovery found = recovery(scene, played, of_lines);
        MESSAGE(std::string(of_lines ? "lines" : "points")
                << ": driving weight " << found.driving_weight << ", believed after "
                << found.believed_s.value_or(std::nan("")) << " s, weight " << found.parked_weight
                << ", disbelieved after " << found.disbelieved_s.value_or(std::nan("")) << " s; "
                << told(played, 3.0));
        // Lines on it are too few while it drives to ask the same of them.
        if (!of_lines) CHECK(found.driving_weight < 0.5);
        CHECK(found.believed_s.value_or(9.0) < 0.7);
        CHECK(found.parked_weight > 0.5);
        CHECK(found.disbelieved_s.value_or(9.0) < 0.7);
      }
    }
  }

  // Half of the view, believed for seconds, leaves gently: the hardest there is.
  TEST_CASE("a bus that drives off shifts the estimate by a quarter metre at most, for a moment") {
    SimulationOptions options = calm("car_park", 8.5);
    options.seed = 2;
    options.bus = {.at_s = 4.5, .stand_s = 2.5, .away_m = 7.0};
    const Played played = SimulatedScene("drives-off", options).play();
    MESSAGE(told(played, 3.0));
    CHECK(played.worst_error_m(3.0) < 0.25);
    // A second after it began to move all is as before.
    CHECK(played.worst_error_m(8.0, 3.0) < 0.05);
  }

  TEST_CASE("turning on the spot, from a flight on, does not take it away") {
    const SimulatedScene scene("turns", calm("room", 9.0), [](double t_s) {
      Station at = flight_until(3.0, t_s);
      const double x = std::clamp(t_s - 4.0, 0.0, 1.0);
      const double share = x * x * x * (10.0 + x * (-15.0 + 6.0 * x));
      at.heading_rad += share * 0.8 * std::sin(1.2 * (t_s - 4.0));
      at.pitch_rad += share * 0.15 * std::sin(0.9 * (t_s - 4.0));
      return at;
    });
    const Played played = scene.play();
    MESSAGE(told(played));
    check_no_reset(played);
    CHECK(played.worst_error_m(1.5) < 0.05);
  }

  TEST_CASE("going straight along the lines of a room keeps it right") {
    const SimulatedScene scene("straight", calm("room", 8.0), [](double t_s) {
      Station at = flight_until(3.0, t_s);
      const double x = std::max(0.0, t_s - 4.0);  // from rest to 0.5 m/s within 1.5 s
      const double s = std::min(1.0, x / 1.5);
      at.p_m.x() += 0.5 * (1.5 * s * s * s * s * (2.5 - 3.0 * s + s * s) + std::max(0.0, x - 1.5));
      return at;
    });
    const Played played = scene.play();
    MESSAGE(told(played));
    check_no_reset(played);
    CHECK(played.worst_error_m(1.5) < 0.05);
  }

  TEST_CASE("without a straight edge, and with edges everywhere, lines do not harm") {
    for (const Surfaces surfaces : {Surfaces::kPebbles, Surfaces::kStripes}) {
      CAPTURE(static_cast<int>(surfaces));
      SimulationOptions options = calm("room", 6.0);
      options.surfaces = surfaces;
      const SimulatedScene scene("surfaces", options);
      const Played with = scene.play(), without = scene.play(kWithoutLines);
      MESSAGE(std::string(surfaces == Surfaces::kPebbles ? "pebbles" : "stripes")
              << " with lines: " << told(with) << "; without: " << told(without));
      check_no_reset(with);
      check_no_reset(without);
      const double lines = with.report["features_per_frame"]["lines"].get<double>();
      if (surfaces == Surfaces::kPebbles)
        CHECK(lines < 5.0);
      else
        CHECK((lines > 40.0 && lines <= 64.0));
      REQUIRE(with.evaluation.ate_rmse_m.has_value());
      REQUIRE(without.evaluation.ate_rmse_m.has_value());
      CHECK(*with.evaluation.ate_rmse_m < 1.05 * *without.evaluation.ate_rmse_m);
    }
  }
}
