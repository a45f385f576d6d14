#include "pled_vins/events/config.hpp"

#include <limits>
#include <string_view>

#include <doctest/doctest.h>

namespace pled {

TEST_SUITE("events.config") {
  TEST_CASE("each setting out of range is named, NaN too") {
    const auto broken = [](auto change) {
      EventConfig config;
      change(config);
      const ConfigIssue issue = check(config);
      return std::string_view(issue.key == nullptr ? "" : issue.key);
    };
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    CHECK(broken([](EventConfig&) {}) == "");
    CHECK(broken([](EventConfig& c) { c.redundant_ms = -1; }) == "events.redundant_ms");
    CHECK(broken([](EventConfig& c) { c.redundant_ms = kNaN; }) == "events.redundant_ms");
    CHECK(broken([](EventConfig& c) { c.hot_rate_hz = 10; }) == "events.hot_rate_hz");
    CHECK(broken([](EventConfig& c) { c.hot_burst = 1; }) == "events.hot_burst");
    CHECK(broken([](EventConfig& c) { c.hot_burst = 31; }) == "events.hot_burst");
    CHECK(broken([](EventConfig& c) { c.surface_decay_ms = kNaN; }) == "events.surface_decay_ms");
    CHECK(broken([](EventConfig& c) { c.corner_min_distance_px = 2; }) ==
          "events.corner_min_distance_px");
    // The tracker that follows the corners takes no more.
    CHECK(broken([](EventConfig& c) { c.corner_min_distance_px = 101; }) ==
          "events.corner_min_distance_px");
    CHECK(broken([](EventConfig& c) { c.corner_max_age_ms = 0; }) == "events.corner_max_age_ms");
    CHECK(broken([](EventConfig& c) { c.corner_max_candidates = 0; }) ==
          "events.corner_max_candidates");
  }
}

}  // namespace pled
