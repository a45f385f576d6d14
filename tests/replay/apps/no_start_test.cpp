// The one behaviour that is cheap enough for every run; the others are in behaviour_test.cpp.

#include <cmath>

#include <doctest/doctest.h>

#include "tests/support/simulated_scene.hpp"

TEST_SUITE("apps.no_start") {
  TEST_CASE("a rig that only ever turned on the spot is given no place, for it has none to tell") {
    using namespace pled::support;
    pled::sim::SimulationOptions options = *pled::sim::preset("test");
    options.duration_s = 3.0;
    const SimulatedScene scene("turned", options, [](double t_s) {
      return Station{{}, 0.8 * std::sin(1.2 * t_s), 0.15 * std::sin(0.9 * t_s)};
    });
    const Played played = scene.play();
    CHECK(played.evaluation.poses == 0);
    CHECK(played.report["initialised_at_s"].is_null());
    CHECK(played.report["faults"].empty());
  }
}
