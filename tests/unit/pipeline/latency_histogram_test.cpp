#include "pled_vins/pipeline/latency_histogram.hpp"

#include <doctest/doctest.h>

using pled::LatencyHistogram;

TEST_SUITE("pipeline.latency_histogram") {
  TEST_CASE("an empty histogram gives zeros") {
    const LatencyHistogram h;
    CHECK(h.count() == 0);
    CHECK(h.quantile_us(0.5) == 0.0);
    CHECK(h.max_us() == 0.0);
    CHECK(h.mean_us() == 0.0);
  }

  TEST_CASE("quantiles of 1 ... 1000 us are right to 2 %") {
    LatencyHistogram h;
    for (int us = 1; us <= 1000; ++us) h.add_ns(us * 1000);
    CHECK(h.count() == 1000);
    CHECK(h.quantile_us(0.5) == doctest::Approx(500.0).epsilon(0.021));
    CHECK(h.quantile_us(0.99) == doctest::Approx(990.0).epsilon(0.021));
    CHECK(h.max_us() == 1000.0);
    CHECK(h.mean_us() == doctest::Approx(500.5));
  }

  TEST_CASE("a quantile never exceeds the maximum, which is exact") {
    LatencyHistogram h;
    h.add_ns(123'456'789);
    CHECK(h.quantile_us(1.0) == doctest::Approx(123'456.789));
    CHECK(h.max_us() == doctest::Approx(123'456.789));
  }

  TEST_CASE("negative and absurdly long durations are counted, not lost") {
    LatencyHistogram h;
    h.add_ns(-5);
    h.add_ns(INT64_C(9'000'000'000'000));
    CHECK(h.count() == 2);
    CHECK(h.max_us() == doctest::Approx(9e9));
  }
}
