#include "pled_vins/core/timestamp.hpp"

#include <array>
#include <cstdint>
#include <limits>

#include <doctest/doctest.h>

namespace pled {
namespace {

TEST_SUITE("core.timestamp") {
  TEST_CASE("seconds round to the nearest microsecond on both sides of zero") {
    CHECK(Duration::from_s(0.0000014).us == 1);
    CHECK(Duration::from_s(0.0000016).us == 2);
    CHECK(Duration::from_s(-0.0000014).us == -1);
    CHECK(Duration::from_s(-0.0000016).us == -2);
    CHECK(Duration::from_s(0.05).us == 50'000);
    CHECK(Duration::from_s(-3.25).us == -3'250'000);
  }

  TEST_CASE("seconds that no span can have are held at the largest one, NaN at none") {
    static_assert(Duration::from_s(1e15).us == 4'000'000'000'000'000'000);
    static_assert(Duration::from_s(-1e300).us == -4'000'000'000'000'000'000);
    CHECK(Duration::from_s(std::numeric_limits<double>::infinity()) == Duration::from_s(1e15));
    CHECK(Duration::from_s(std::numeric_limits<double>::quiet_NaN()).us == 0);
    CHECK((Timestamp{1'721'000'000'123'457} + Duration::from_s(1e15)).us > 0);
  }

  TEST_CASE("milliseconds and seconds name the same span") {
    CHECK(Duration::from_ms(40) == Duration::from_s(0.04));
    CHECK(Duration::from_ms(-7).seconds() == doctest::Approx(-0.007));
  }

  TEST_CASE("whole microseconds survive the way through seconds over a day") {
    constexpr std::int64_t kDay_us = 86'400'000'000;
    for (const std::int64_t us : std::array<std::int64_t, 4>{1, 999'999, kDay_us - 1, kDay_us}) {
      CAPTURE(us);
      CHECK(Duration::from_s(Duration{us}.seconds()).us == us);
      CHECK(Duration::from_s(-Duration{us}.seconds()).us == -us);
    }
  }

  TEST_CASE("moving an instant by a span and back returns the instant") {
    // An instant of 2024 counted from 1970, as recordings have it.
    constexpr Timestamp kThen{1'721'000'000'123'457};
    constexpr Duration kSpan{33'333};
    CHECK((kThen + kSpan).us == 1'721'000'000'156'790);
    CHECK((kThen + kSpan) - kSpan == kThen);
    CHECK((kThen + kSpan) - kThen == kSpan);
    CHECK(kThen - (kThen + kSpan) == -kSpan);
  }

  TEST_CASE("spans add, subtract and order like integers") {
    constexpr Duration kA{5};
    constexpr Duration kB{-8};
    CHECK((kA + kB).us == -3);
    CHECK((kA - kB).us == 13);
    CHECK(kB < kA);
    CHECK(Timestamp{-1} < Timestamp{0});
    CHECK(Timestamp{2} >= Timestamp{2});
  }
}

}  // namespace
}  // namespace pled
