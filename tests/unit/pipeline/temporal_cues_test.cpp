#include "pled_vins/pipeline/temporal_cues.hpp"

#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/reliability/event_count.hpp"
#include "support/pipeline/stage_run.hpp"

namespace pled {
namespace {

constexpr double kSpeed_mps = 0.8;
constexpr std::int64_t kFrame_us = 50'000;

/// Goes along x at constant speed: nothing but gravity on the accelerometer.
NavState state_at(std::int64_t t_us) {
  NavState x;
  x.t = Timestamp{t_us};
  x.v_wb = {kSpeed_mps, 0, 0};
  x.p_wb = x.v_wb * (static_cast<double>(t_us) * 1e-6);
  return x;
}

struct Cruise {
  explicit Cruise(bool read_map) : rig(support::event_rig(false)), cues({}, rig, read_map) {
    for (std::int64_t t = 0; t <= 2'000'000; t += 5000)
      imu->add({{t}, {0, 0, 0}, {0, 0, rig.imu.gravity_mps2}});
  }

  /// Frame k: one point at rest, one that sinks, both 2 m away.
  FrameMeasurement frame(int k) const {
    FrameMeasurement f;
    f.t = Timestamp{1'000'000 + k * kFrame_us};
    const Eigen::Vector3d rest(1.1, 0.1, 2.0);
    const Eigen::Vector3d sinks(1.0, -0.2 + 0.05 * k, 2.0);
    FeatureId id = 1;
    for (const Eigen::Vector3d& p_w : {rest, sinks}) {
      PointMeasurement p;
      p.id = id++;
      const Eigen::Vector2d at = (p_w - state_at(f.t.us).p_wb).hnormalized();
      p.bearing_xy = {at.x(), at.y()};
      (void)f.points.push_back(p);
    }
    return f;
  }

  RigCalibration rig;
  TemporalCues cues;
  std::unique_ptr<ImuHistory> imu = std::make_unique<ImuHistory>();
};

}  // namespace

TEST_SUITE("pipeline.temporal_cues") {
  TEST_CASE("the state before a frame and the gyro are enough to tell what moves") {
    Cruise cruise(false);
    for (int k = 0; k < 5; ++k) {
      const FrameMeasurement f = cruise.frame(k);
      const NavState before = state_at(f.t.us - kFrame_us);
      const auto weights = cruise.cues.judge(f, *cruise.imu, before, nullptr);
      REQUIRE(weights.size() == 2);
      CAPTURE(k);
      if (k == 0) {
        CHECK(std::isnan(weights[0].motion));
        continue;
      }
      CHECK(weights[0].motion > 0.9);
      CHECK(weights[1].motion < 0.2);
      CHECK(std::isnan(weights[0].paper));
      CHECK(std::isnan(weights[0].count));
      CHECK(weights[0].of(TemporalScore::kMotion) == weights[0].motion);
    }
  }

  TEST_CASE(
      "while nothing is known of the state, or the inertial data have a hole, nobody is judged") {
    Cruise cruise(false);
    for (int k = 0; k < 3; ++k) {
      const auto weights = cruise.cues.judge(cruise.frame(k), *cruise.imu, std::nullopt, nullptr);
      CHECK(std::isnan(weights[0].motion));
      CHECK(std::isnan(weights[1].motion));
    }
    const auto empty = std::make_unique<ImuHistory>();
    const auto hole = cruise.cues.judge(cruise.frame(3), *empty, state_at(1'000'000), nullptr);
    CHECK(std::isnan(hole[1].motion));
    // Those frames were kept all the same.
    const auto weights =
        cruise.cues.judge(cruise.frame(4), *cruise.imu, state_at(1'150'000), nullptr);
    CHECK(weights[1].motion < 0.2);
    cruise.cues.reset();
    const auto anew = cruise.cues.judge(cruise.frame(5), *cruise.imu, state_at(1'200'000), nullptr);
    CHECK(std::isnan(anew[1].motion));
  }

  TEST_CASE("the map is read where each point is seen, and only when it is to be") {
    for (const bool read_map : {true, false}) {
      CAPTURE(read_map);
      Cruise cruise(read_map);
      EventStageConfig config;
      config.events.max_points = 0;
      config.keep_map = true;
      auto storage = std::make_unique<support::EventStorage>();
      EventStage stage(config, cruise.rig, storage->view());
      const FrameMeasurement f = cruise.frame(0);
      const Camera camera(cruise.rig.cameras[0]);
      const auto px = camera.project({f.points[1].bearing_xy[0], f.points[1].bearing_xy[1], 1.0});
      REQUIRE(px);
      stage.follow_turn(*cruise.imu, Eigen::Vector3d::Zero());
      stage.expect(f.t);
      const std::vector<Event> events(
          6, {f.t - Duration{3000}, static_cast<std::uint16_t>(std::lround(px->x())),
              static_cast<std::uint16_t>(std::lround(px->y())), Polarity::kOn});
      stage.on_events(events);
      FrameMeasurement points;
      stage.observe(f.t, 0, std::nullopt, points);
      const auto weights = cruise.cues.judge(f, *cruise.imu, std::nullopt, &stage);
      CHECK(std::isnan(weights[0].paper));  // no event there
      CHECK(std::isnan(weights[0].count));
      CHECK(std::isnan(weights[1].motion));
      REQUIRE(std::isnan(weights[1].count) != read_map);
      REQUIRE(std::isnan(weights[1].paper) != read_map);
      if (!read_map) continue;
      CHECK(weights[1].count == doctest::Approx(event_count_reliability(6)));
      CHECK(weights[1].of(TemporalScore::kCount) == weights[1].count);
      // All in one bin: entropy 0, so the paper calls it at rest.
      CHECK(weights[1].paper == doctest::Approx(1.0).epsilon(1e-6));
      CHECK(weights[1].of(TemporalScore::kPaper) == weights[1].paper);
    }
  }
}

}  // namespace pled
