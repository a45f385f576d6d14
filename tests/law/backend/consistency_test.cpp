#include <doctest/doctest.h>

#include "tests/support/simulated_run.hpp"

TEST_SUITE("backend.consistency") {
  TEST_CASE("the mean NEES of the newest pose lies within its 95 % bounds at few runs") {
    const pled::support::Consistency c = pled::support::check_consistency(6, 2.0, 100);
    CAPTURE(c.mean);
    CHECK(c.mean >= c.lower);
    CHECK(c.mean <= c.upper);
  }
}
