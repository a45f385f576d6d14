#include "pled_vins/imu/imu_history.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"

namespace {

using pled::Duration;
using pled::ImuHistory;
using pled::ImuSample;
using pled::Timestamp;

/// Values that tell when a sample was taken: linear in time.
ImuSample ramp(std::int64_t t_us) {
  const double t_s = static_cast<double>(t_us) * 1e-6;
  return {{t_us}, {t_s, 2.0 * t_s, -t_s}, {1.0 + t_s, 3.0 * t_s, 9.81}};
}

std::unique_ptr<ImuHistory> ramps(std::int64_t first_us, std::int64_t step_us, int count) {
  auto h = std::make_unique<ImuHistory>();
  for (int i = 0; i < count; ++i) REQUIRE(h->add(ramp(first_us + i * step_us)));
  return h;
}

/// A buffer whose every value is wrong until written.
std::vector<ImuSample> poisoned(std::size_t size = 64) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  return std::vector<ImuSample>(size, {{-1}, {kNaN, kNaN, kNaN}, {kNaN, kNaN, kNaN}});
}

void check_is_ramp(const ImuSample& s, std::int64_t t_us) {
  CAPTURE(t_us);
  CHECK(s.t.us == t_us);
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(s.gyro_radps[k] == doctest::Approx(ramp(t_us).gyro_radps[k]).epsilon(1e-12));
    CHECK(s.accel_mps2[k] == doctest::Approx(ramp(t_us).accel_mps2[k]).epsilon(1e-12));
  }
}

}  // namespace

TEST_SUITE("imu.history") {
  TEST_CASE("an empty history has no ends, no median and covers nothing") {
    const auto h = std::make_unique<ImuHistory>();
    auto out = poisoned();
    bool has_gap = false;
    CHECK_FALSE(h->newest().has_value());
    CHECK_FALSE(h->oldest().has_value());
    CHECK(h->median_period().us == 0);
    CHECK(h->gap_threshold().us == 25'000);
    CHECK(h->interval({0}, {1000}, out, has_gap) == 0);
    CHECK_FALSE(h->rotation({0}, {1000}, Eigen::Vector3d::Zero()).has_value());
  }

  TEST_CASE("duplicate, backward and non-finite samples are dropped and counted") {
    const auto h = ramps(0, 5000, 3);
    CHECK_FALSE(h->add(ramp(10'000)));
    CHECK_FALSE(h->add(ramp(9'999)));
    CHECK_FALSE(h->add(ramp(0)));
    ImuSample bad = ramp(15'000);
    bad.accel_mps2[2] = std::numeric_limits<double>::quiet_NaN();
    CHECK_FALSE(h->add(bad));
    bad = ramp(15'000);
    bad.gyro_radps[0] = std::numeric_limits<double>::infinity();
    CHECK_FALSE(h->add(bad));
    CHECK(h->add(ramp(15'000)));
    CHECK(h->size() == 4);
    CHECK(h->faults().duplicates == 1);
    CHECK(h->faults().backwards == 2);
    CHECK(h->faults().not_finite == 2);
    CHECK(h->faults().gaps == 0);
  }

  TEST_CASE("a number that no sensor can give is dropped and counted") {
    auto h = ramps(0, 5000, 10);
    for (const double wild : {1e300, -2000.0, 351.0}) {
      ImuSample s = ramp(50'000);
      s.accel_mps2[1] = wild;
      CHECK(!h->add(s));
    }
    ImuSample s = ramp(50'000);
    s.gyro_radps[2] = -76.0;
    CHECK(!h->add(s));
    CHECK(h->faults().implausible == 4);
    CHECK(h->add(ramp(50'000)));
    CHECK(h->faults().gaps == 0);
  }

  TEST_CASE("a lone spike never gets in, what lasts does") {
    auto h = ramps(0, 5000, 10);
    ImuSample spike = ramp(50'000);
    spike.accel_mps2[0] = 200.0;
    CHECK(h->add(spike));  // may still be the truth
    CHECK(h->size() == 10);
    CHECK(!h->add(spike));  // the same again
    CHECK(h->faults().duplicates == 1);
    CHECK(h->add(ramp(55'000)));
    CHECK(h->faults().implausible == 1);
    CHECK(h->size() == 11);
    CHECK((*h)[9].t.us == 45'000);
    CHECK((*h)[10].t.us == 55'000);

    auto landing = ramps(0, 5000, 10);
    for (int k = 0; k < 2; ++k) {  // two samples at 150 m/s^2: something happened
      ImuSample s = ramp(50'000 + 5000 * k);
      s.accel_mps2[2] = 150.0;
      CHECK(landing->add(s));
    }
    CHECK(landing->size() == 12);
    CHECK(landing->add(ramp(60'000)));  // back at rest: may be a spike of its own
    CHECK(landing->add(ramp(65'000)));
    CHECK(landing->size() == 14);
    CHECK(landing->faults().implausible == 0);

    auto turn = ramps(0, 5000, 10);
    ImuSample s = ramp(50'000);
    s.gyro_radps[0] += 6.0;  // less than a jump
    CHECK(turn->add(s));
    CHECK(turn->size() == 11);
  }

  TEST_CASE("the ends are interpolated to the microsecond and the middle is as measured") {
    const auto h = ramps(0, 5000, 10);
    auto out = poisoned();
    bool has_gap = true;
    const std::size_t n = h->interval({7'001}, {23'456}, out, has_gap);
    REQUIRE(n == 5);
    CHECK_FALSE(has_gap);
    const std::array<std::int64_t, 5> want{7'001, 10'000, 15'000, 20'000, 23'456};
    for (std::size_t i = 0; i < n; ++i) check_is_ramp(out[i], want[i]);
    CHECK(out[5].t.us == -1);
  }

  TEST_CASE("an end on a sample is that sample, once") {
    const auto h = ramps(0, 5000, 10);
    auto out = poisoned();
    bool has_gap = true;
    REQUIRE(h->interval({5'000}, {15'000}, out, has_gap) == 3);
    for (std::size_t i = 0; i < 3; ++i) {
      check_is_ramp(out[i], 5'000 + static_cast<std::int64_t>(i) * 5'000);
    }
  }

  TEST_CASE("a span inside one step has its two ends") {
    const auto h = ramps(0, 5000, 10);
    auto out = poisoned();
    bool has_gap = true;
    REQUIRE(h->interval({6'000}, {7'000}, out, has_gap) == 2);
    check_is_ramp(out[0], 6'000);
    check_is_ramp(out[1], 7'000);
  }

  TEST_CASE("an end beyond the samples repeats the nearest one, up to the gap threshold") {
    const auto h = ramps(100'000, 5000, 5);  // to 120 ms
    auto out = poisoned();
    bool has_gap = true;
    REQUIRE(h->interval({110'000}, {145'000}, out, has_gap) == 4);
    CHECK(out[3].t.us == 145'000);
    CHECK(out[3].gyro_radps == ramp(120'000).gyro_radps);
    CHECK(h->interval({110'000}, {145'001}, out, has_gap) == 0);
    REQUIRE(h->interval({75'000}, {102'000}, out, has_gap) == 3);
    CHECK(out[0].t.us == 75'000);
    CHECK(out[0].accel_mps2 == ramp(100'000).accel_mps2);
    CHECK(h->interval({74'999}, {102'000}, out, has_gap) == 0);
    REQUIRE(h->interval({121'000}, {130'000}, out, has_gap) == 2);
    CHECK(out[0].gyro_radps == out[1].gyro_radps);
  }

  TEST_CASE("a refused span leaves the buffer alone") {
    const auto h = ramps(0, 5000, 10);
    auto out = poisoned(3);
    bool has_gap = true;
    CHECK(h->interval({7'001}, {23'456}, out, has_gap) == 0);  // needs 5
    CHECK(h->interval({10'000}, {10'000}, out, has_gap) == 0);
    CHECK(h->interval({10'000}, {9'000}, out, has_gap) == 0);
    for (const ImuSample& s : out) CHECK(s.t.us == -1);
  }

  TEST_CASE("a gap is seen by the spans that touch it and by no other") {
    auto h = ramps(0, 5000, 11);             // to 50 ms
    REQUIRE(h->add(ramp(50'000 + 25'001)));  // one microsecond too long
    for (int i = 1; i < 10; ++i) REQUIRE(h->add(ramp(75'001 + i * 5000)));
    CHECK(h->faults().gaps == 1);
    auto out = poisoned();
    bool has_gap = false;
    CHECK(h->interval({40'000}, {80'001}, out, has_gap) > 0);
    CHECK(has_gap);
    CHECK(h->interval({60'000}, {70'000}, out, has_gap) == 2);
    CHECK(has_gap);
    CHECK(h->interval({60'000}, {80'001}, out, has_gap) > 0);
    CHECK(has_gap);
    CHECK(h->interval({10'000}, {50'000}, out, has_gap) > 0);
    CHECK_FALSE(has_gap);
    CHECK(h->interval({75'001}, {90'000}, out, has_gap) > 0);
    CHECK_FALSE(has_gap);
    CHECK_FALSE(h->rotation({40'000}, {80'001}, Eigen::Vector3d::Zero()).has_value());
    CHECK(h->rotation({75'001}, {90'000}, Eigen::Vector3d::Zero()).has_value());
  }

  TEST_CASE("steps of 25 ms, or of four medians where those are longer, are no gap") {
    auto fast = ramps(0, 5000, 40);
    REQUIRE(fast->add(ramp(195'000 + 25'000)));
    CHECK(fast->faults().gaps == 0);
    auto slow = ramps(0, 10'000, 40);
    CHECK(slow->gap_threshold().us == 40'000);
    REQUIRE(slow->add(ramp(390'000 + 40'000)));
    CHECK(slow->faults().gaps == 0);
    REQUIRE(slow->add(ramp(430'000 + 40'001)));
    CHECK(slow->faults().gaps == 1);
  }

  TEST_CASE("a jittered 220 Hz stream with steps under 1 ms and one of 20 ms has no gap") {
    const auto h = std::make_unique<ImuHistory>();
    std::int64_t t_us = 0;
    for (int i = 0; i < 3000; ++i) {
      const std::int64_t step_us =
          i == 1500 ? 20'000 : (i % 10 == 3 ? 600 : (i % 10 == 4 ? 8'490 : 4'545));
      t_us += step_us;
      REQUIRE(h->add(ramp(t_us)));
    }
    CHECK(h->median_period().us == 4'545);
    CHECK(h->faults().gaps == 0);
  }

  TEST_CASE("the median survives fifteen odd steps in thirty-one") {
    auto h = ramps(0, 5000, 40);
    for (int i = 1; i <= 15; ++i) REQUIRE(h->add(ramp(195'000 + i * 100)));
    CHECK(h->median_period().us == 5000);
  }

  TEST_CASE("a full history lets the oldest go, a fault only when it was still needed") {
    constexpr int kMore = 100;
    auto h = ramps(0, 1000, static_cast<int>(pled::limits::kImuHistory));
    h->release_before({50'000});
    const auto end_us = static_cast<std::int64_t>(pled::limits::kImuHistory) * 1000;
    for (int i = 0; i < kMore; ++i) REQUIRE(h->add(ramp(end_us + i * 1000)));
    CHECK(h->size() == pled::limits::kImuHistory);
    CHECK(h->oldest()->us == 100'000);
    CHECK(h->newest()->us == end_us + (kMore - 1) * 1000);
    CHECK(h->faults().overwritten == 50);  // those at 50 ms to 99 ms
    auto out = poisoned();
    bool has_gap = true;
    REQUIRE(h->interval({100'500}, {102'500}, out, has_gap) == 4);
    check_is_ramp(out[0], 100'500);
    check_is_ramp(out[3], 102'500);
    for (std::size_t i = 1; i < h->size(); ++i) REQUIRE((*h)[i].t > (*h)[i - 1].t);
  }

  TEST_CASE("clear forgets samples, median and faults") {
    auto h = ramps(0, 5000, 10);
    CHECK_FALSE(h->add(ramp(0)));
    h->clear();
    CHECK(h->size() == 0);
    CHECK(h->median_period().us == 0);
    CHECK(h->faults().backwards == 0);
    CHECK(h->add(ramp(0)));
  }

  TEST_CASE("rotation at a constant rate is exp of rate times time, bias removed") {
    const auto h = std::make_unique<ImuHistory>();
    const Eigen::Vector3d w(0.5, -1.0, 2.0);
    const Eigen::Vector3d bias(0.01, 0.02, -0.03);
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector3d read = w + bias;
      REQUIRE(h->add({{i * 5000}, {read.x(), read.y(), read.z()}, {0.0, 0.0, 9.81}}));
    }
    const auto q = h->rotation({1'234}, {301'234}, bias);
    REQUIRE(q.has_value());
    CHECK((pled::so3::log(*q) - 0.3 * w).norm() < 1e-13);
    CHECK(h->rotation({1'234}, {1'234}, bias)->isApprox(Eigen::Quaterniond::Identity()));
    CHECK_FALSE(h->rotation({2'000}, {1'234}, bias).has_value());
  }
}
