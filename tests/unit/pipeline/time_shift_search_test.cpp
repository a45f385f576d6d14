#include "pled_vins/pipeline/time_shift_search.hpp"

#include <cmath>
#include <memory>
#include <random>

#include <doctest/doctest.h>

namespace {

using namespace pled;

/// A hand's turning: some slow waves about each axis, rad/s.
Eigen::Vector3d body_rate(double t_s) {
  return {0.3 * std::sin(2.1 * t_s) + 0.1 * std::cos(5.3 * t_s), 0.25 * std::sin(1.7 * t_s + 1),
          0.2 * std::cos(2.9 * t_s + 0.5)};
}

struct World {
  double turning = 1.0;      ///< factor on body_rate
  double offset_s = 0.0;     ///< true time of a frame = its stamp + offset
  double sideways = 0.0;     ///< translation over depth, rad/s of image motion
  double mover_share = 0;    ///< of the points, that go their own way
  double foreign_share = 0;  ///< of the points, that another camera sees: it looks elsewhere
};

/// Plays five seconds and asks at the end.
std::optional<Duration> search(const World& world) {
  const auto imu = std::make_unique<ImuHistory>();
  const Eigen::Vector3d bias(0.02, -0.01, 0.03);
  for (std::int64_t us = 0; us <= 5'600'000; us += 5000) {
    const Eigen::Vector3d w = world.turning * body_rate(1e-6 * static_cast<double>(us)) + bias;
    REQUIRE(imu->add({Timestamp{us}, {w.x(), w.y(), w.z()}, {0, 0, 9.81}}));
  }
  // The camera looks along the body's x: the search is not told.
  Eigen::Matrix3d R_cam_body;
  R_cam_body << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  std::mt19937_64 random(3);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  TimeShiftSearch searcher;
  constexpr std::int64_t kPeriod_us = 50'000;
  for (std::int64_t us = 300'000; us <= 5'300'000; us += kPeriod_us) {
    // Mean rate over the interval that the frames truly span, by Simpson's rule.
    const double to_s = 1e-6 * static_cast<double>(us) + world.offset_s;
    const double from_s = to_s - 1e-6 * kPeriod_us;
    const Eigen::Vector3d mean =
        (body_rate(from_s) + 4 * body_rate(0.5 * (from_s + to_s)) + body_rate(to_s)) / 6;
    const Eigen::Vector3d w = world.turning * R_cam_body * mean;
    FrameMeasurement frame;
    for (std::uint32_t i = 0; i < 60; ++i) {
      PointMeasurement p;
      p.id = i;
      p.track_length = 5;
      p.camera = unit() < world.foreign_share ? 0 : 1;
      const double x = 1.2 * unit() - 0.6;
      const double y = 0.9 * unit() - 0.45;
      const double nearness = 0.2 + unit();
      p.bearing_xy = {x, y};
      // Rotational flow of a pinhole camera (Longuet-Higgins and Prazdny, 1980).
      p.bearing_rate_xyps = {
          x * y * w.x() - (1 + x * x) * w.y() + y * w.z() + nearness * world.sideways +
              0.01 * (unit() - 0.5),
          (1 + y * y) * w.x() - x * y * w.y() - x * w.z() + 0.01 * (unit() - 0.5)};
      if (unit() < world.mover_share) p.bearing_rate_xyps = {0.5, -0.3};
      if (p.camera == 0)
        p.bearing_rate_xyps = {-p.bearing_rate_xyps[1], 3 * p.bearing_rate_xyps[0]};
      REQUIRE(frame.points.push_back(p));
    }
    searcher.observe(Timestamp{us - kPeriod_us}, Timestamp{us}, frame, 1);
  }
  return searcher.find(*imu);
}

}  // namespace

TEST_SUITE("pipeline.time_shift_search") {
  TEST_CASE("an offset of either sign is found to two milliseconds") {
    for (const double offset_s : {-0.08, -0.045, -0.02, 0.02, 0.05, 0.09}) {
      CAPTURE(offset_s);
      const auto shift = search({.offset_s = offset_s});
      REQUIRE(shift.has_value());
      CHECK(std::abs(shift->seconds() - offset_s) < 0.002);
    }
  }

  TEST_CASE("sideways motion and movers do not mislead it") {
    const auto shift = search({.offset_s = -0.045, .sideways = 0.15, .mover_share = 0.3});
    REQUIRE(shift.has_value());
    CHECK(std::abs(shift->seconds() + 0.045) < 0.005);
  }

  TEST_CASE("points of another camera do not count, however many") {
    const auto shift = search({.offset_s = -0.045, .foreign_share = 0.7});
    REQUIRE(shift.has_value());
    CHECK(std::abs(shift->seconds() + 0.045) < 0.003);
    CHECK(!search({.offset_s = -0.045, .foreign_share = 1.0}).has_value());
  }

  TEST_CASE("clocks that agree, or nearly, are left alone") {
    CHECK(!search({.offset_s = 0.0}).has_value());
    CHECK(!search({.offset_s = 0.008}).has_value());
    CHECK(!search({.offset_s = 0.0, .sideways = 0.3, .mover_share = 0.4}).has_value());
  }

  TEST_CASE("without turning, or beyond its reach, it does not guess") {
    CHECK(!search({.turning = 0.02, .offset_s = 0.05}).has_value());
    CHECK(!search({.offset_s = 0.14}).has_value());
  }

  TEST_CASE("nothing observed, nothing found") {
    const auto imu = std::make_unique<ImuHistory>();
    CHECK(!TimeShiftSearch{}.find(*imu).has_value());
  }
}
