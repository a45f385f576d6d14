#include "src/report/rates.hpp"

#include <vector>

#include <doctest/doctest.h>

namespace {

using namespace pled::report;

constexpr std::int64_t kMs = 1'000'000;

TEST_SUITE("report.rates") {
  TEST_CASE("stamps are counted by the second from the first frame on, a gap is named") {
    std::vector<std::int64_t> stamps;
    for (std::int64_t t = 4'000; t < 7'500; t += 50)
      if (t <= 5'500 || t >= 5'900) stamps.push_back(t * kMs);
    const Json rates = rates_of(stamps, {5'000 * kMs, 7'000 * kMs}, 1.5, 0);
    CHECK(rates["per_s"] == Json::parse("[13, 20, 1]"));
    REQUIRE(rates["gaps"].size() == 1);
    CHECK(rates["gaps"][0][0] == 0.5);
    CHECK(rates["gaps"][0][1] == 0.4);
    CHECK(rates["gap_count"] == 1);
    CHECK(rates["gap_limit_s"] == 0.075);
  }

  TEST_CASE("a stream that begins late has a gap at its start; one without anything has none") {
    CHECK(rates_of(std::vector<std::int64_t>{900 * kMs, 1000 * kMs}, {0, 1000 * kMs}, 1.5, 0)
              .at("gaps") == Json::parse("[[0.0, 0.9]]"));
    const Json nothing = rates_of({}, {0, 2'500 * kMs}, 1.5, 0);
    CHECK(nothing["per_s"] == Json::parse("[0, 0, 0]"));
    CHECK(nothing["gaps"].empty());
  }
}

}  // namespace
