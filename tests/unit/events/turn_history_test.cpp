#include "pled_vins/events/turn_history.hpp"

#include <limits>
#include <memory>

#include <doctest/doctest.h>

#include "support/events/turning_camera.hpp"

namespace pled {
namespace {

const Eigen::Vector3d kNoBias = Eigen::Vector3d::Zero();
const Eigen::Quaterniond kSameFrame = Eigen::Quaterniond::Identity();

ImuSample sample(std::int64_t t_us, double rate_radps) {
  return {{t_us}, {0.0, 0.0, rate_radps}, {}};
}

bool extend(TurnHistory& turn, const ImuSample& s) {
  return turn.extend({&s, 1}, kNoBias, kSameFrame);
}

/// Every millisecond from `from_us` to `to_us`.
void fill(TurnHistory& turn, std::int64_t from_us, std::int64_t to_us, double rate_radps = 1.0) {
  for (std::int64_t t = from_us; t <= to_us; t += 1000) CHECK(extend(turn, sample(t, rate_radps)));
}

}  // namespace

TEST_SUITE("events.turn_history") {
  TEST_CASE("without samples nothing is known") {
    TurnHistory turn;
    CHECK(!turn.oldest());
    CHECK(!turn.newest());
    CHECK(!turn.rotation({0}, {0}));
    CHECK(turn.extend({}, kNoBias, kSameFrame));
    CHECK(!turn.newest());
  }

  TEST_CASE("it knows from the first knot to the newest sample, at most the last second") {
    TurnHistory turn;
    fill(turn, 500, 400'500);
    CHECK(turn.oldest() == Timestamp{1024});
    CHECK(turn.newest() == Timestamp{400'500});
    CHECK(turn.rotation({1024}, {400'500}));
    CHECK(!turn.rotation({1023}, {400'500}));
    CHECK(!turn.rotation({1024}, {400'501}));
    fill(turn, 401'500, 3'000'500);
    CHECK(turn.newest() == Timestamp{3'000'500});
    CHECK(*turn.newest() - *turn.oldest() >= Duration{1'000'000});
    CHECK(turn.rotation(*turn.oldest(), *turn.newest()));
  }

  TEST_CASE("stamps before zero are as good as any") {
    TurnHistory turn;
    fill(turn, -50'000, 50'000, 2.0);
    const std::optional<Eigen::Quaterniond> R = turn.rotation({-40'000}, {40'000});
    REQUIRE(R);
    CHECK((so3::log(*R) - Eigen::Vector3d(0, 0, 0.16)).norm() < 1e-9);
  }

  TEST_CASE("a rate that is not finite is dropped and counted") {
    TurnHistory turn;
    fill(turn, 0, 20'000);
    CHECK(!extend(turn, sample(21'000, std::numeric_limits<double>::quiet_NaN())));
    CHECK(!extend(turn, sample(21'000, std::numeric_limits<double>::infinity())));
    CHECK(turn.faults().not_finite == 2);
    CHECK(turn.newest() == Timestamp{20'000});
    CHECK(extend(turn, sample(22'000, 1.0)));
    CHECK(turn.rotation({0}, {22'000}));
  }

  TEST_CASE("a stamp that goes back is dropped and counted; the newest once more is no fault") {
    TurnHistory turn;
    fill(turn, 0, 20'000);
    CHECK(!extend(turn, sample(19'999, 50.0)));
    CHECK(turn.faults().backwards == 1);
    CHECK(extend(turn, sample(20'000, 50.0)));
    CHECK(turn.faults().backwards == 1);
    const std::optional<Eigen::Quaterniond> R = turn.rotation({0}, {20'000});
    REQUIRE(R);
    CHECK((so3::log(*R) - Eigen::Vector3d(0, 0, 0.02)).norm() < 1e-9);
  }

  TEST_CASE("a gap begins a new history, as nobody knows how the camera turned in it") {
    TurnHistory turn;
    fill(turn, 0, 20'000);
    CHECK(extend(turn, sample(45'000, 1.0)));  // 25 ms are still bridged
    CHECK(!extend(turn, sample(70'001, 1.0)));
    CHECK(turn.faults().gaps == 1);
    fill(turn, 71'001, 90'001);
    CHECK(!turn.rotation({20'000}, {90'000}));
    CHECK(*turn.oldest() > Timestamp{70'000});
    CHECK(turn.rotation(*turn.oldest(), {90'000}));
  }

  TEST_CASE("a clock that was set begins a new history") {
    TurnHistory turn;
    fill(turn, 5'000'000, 5'020'000);
    CHECK(!extend(turn, sample(10'000, 1.0)));
    CHECK(turn.faults().restarts == 1);
    fill(turn, 11'000, 30'000);
    CHECK(turn.newest() == Timestamp{30'000});
    CHECK(*turn.oldest() == Timestamp{10'240});
  }

  TEST_CASE("slices that are not known are refused and leave the output alone") {
    TurnHistory turn;
    fill(turn, 0, 100'000);
    const auto slices = std::make_unique<TurnSlices>();
    slices->count = 12345;
    CHECK(!turn.slices({100'000}, {-1}, {100'000}, 1e-4, *slices));
    CHECK(!turn.slices({100'000}, {0}, {100'001}, 1e-4, *slices));
    CHECK(!turn.slices({100'001}, {0}, {100'000}, 1e-4, *slices));
    CHECK(!turn.slices({100'000}, {60'000}, {50'000}, 1e-4, *slices));
    CHECK(slices->count == 12345);
    CHECK(turn.slices({100'000}, {0}, {100'000}, 1e-4, *slices));
    CHECK(turn.slices({100'000}, {100'000}, {100'000}, 1e-4, *slices));
    CHECK(slices->count == 1);
    CHECK(slices->index(100'000) == 0);
  }

  TEST_CASE("slices cover the span on a grid of their length, and index() finds them") {
    TurnHistory turn;
    fill(turn, 0, 200'000, 2.0);
    const auto slices = std::make_unique<TurnSlices>();
    REQUIRE(turn.slices({200'000}, {70'000}, {200'000}, 2e-4, *slices));
    CHECK(slices->length_log2_us == 7);  // 2 rad/s for 100 us each way: 2^7 us and no longer
    CHECK(slices->begin_us % 128 == 0);
    CHECK(slices->begin_us <= 70'000);
    CHECK(slices->begin_us > 70'000 - 128);
    CHECK(slices->begin_of_us(slices->count) > 200'000);
    CHECK(slices->begin_of_us(slices->count - 1) <= 200'000);
    CHECK(slices->index(slices->begin_us - 1) == slices->count);
    CHECK(slices->index(slices->begin_of_us(slices->count)) == slices->count);
    CHECK(slices->index(std::numeric_limits<std::int64_t>::min()) == slices->count);
    CHECK(slices->index(std::numeric_limits<std::int64_t>::max()) == slices->count);
    for (std::int64_t t = 70'000; t <= 200'000; t += 77) {
      const std::size_t i = slices->index(t);
      REQUIRE(i < slices->count);
      REQUIRE(slices->begin_of_us(i) <= t);
      REQUIRE(slices->begin_of_us(i + 1) > t);
    }
  }

  TEST_CASE(
      "a camera at rest gets slices of a knot, a spinning one no more than there is room for") {
    TurnHistory still;
    fill(still, 0, 900'000, 0.0);
    TurnHistory spinning;
    fill(spinning, 0, 900'000, 40.0);
    const auto slices = std::make_unique<TurnSlices>();
    REQUIRE(still.slices({900'000}, {0}, {900'000}, 1e-4, *slices));
    CHECK(slices->count == 879);  // of 1024 us, the longest
    REQUIRE(spinning.slices({900'000}, {0}, {900'000}, 1e-4, *slices));
    CHECK(slices->count <= limits::kMaxTurnSlices);
    CHECK(slices->count > limits::kMaxTurnSlices / 2);
  }
}

}  // namespace pled
