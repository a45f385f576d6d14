#include <doctest/doctest.h>

#include "src/apps/consistency_check.hpp"

namespace {

using pled::apps::check_consistency;
using pled::apps::Consistency;

}  // namespace

TEST_SUITE("backend.consistency") {
  TEST_CASE("the mean NEES of the newest pose lies within its 95 % bounds at few runs") {
    const Consistency c = check_consistency({.runs = 6, .duration_s = 2.0, .first_seed = 100});
    CAPTURE(c.mean);
    CHECK(c.mean >= c.lower);
    CHECK(c.mean <= c.upper);
  }

  TEST_CASE("the number of jobs changes no bit") {
    const Consistency one = check_consistency({.runs = 3, .duration_s = 1.0, .jobs = 1});
    const Consistency three = check_consistency({.runs = 3, .duration_s = 1.0, .jobs = 3});
    REQUIRE(one.nees.size() == 20);
    CHECK(one.nees == three.nees);
  }

  TEST_CASE("the bounds are the quantiles of chi squared over the runs") {
    // chi^2 with 6 degrees of freedom, from tables: 1.237 and 14.449. The approximation in use
    // is 2.5 % low at the lower one, its worst case; with more degrees it gets better.
    const Consistency c = check_consistency({.runs = 1, .duration_s = 0.6});
    CHECK(c.lower == doctest::Approx(1.237).epsilon(0.02));
    CHECK(c.upper == doctest::Approx(14.449).epsilon(0.005));
  }
}
