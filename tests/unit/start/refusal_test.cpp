#include <limits>
#include <memory>
#include <set>
#include <string>

#include <doctest/doctest.h>

#include "pled_vins/backend/start.hpp"
#include "tests/support/start_world.hpp"

using namespace pled;
using namespace pled::support;

namespace {

PointWorldOptions drone(std::uint64_t seed) {
  PointWorldOptions options;
  options.seed = seed;
  options.duration_s = 3;
  return options;
}

StartGuess guess(const PointWorld& world, const StartFrames& frames) {
  const auto imu = std::make_unique<ImuHistory>();
  fill_history(world, frames.back().t, *imu);
  return guess_start(frames, *imu, world.rig(), start_config());
}

}  // namespace

TEST_SUITE("start.refusal") {
  TEST_CASE("every refusal has its own sentence") {
    std::set<std::string> sentences;
    for (int k = 0; k <= static_cast<int>(StartRefusal::kUnconfirmed); ++k)
      sentences.insert(std::string(to_string(static_cast<StartRefusal>(k))));
    CHECK(sentences.size() == static_cast<std::size_t>(StartRefusal::kUnconfirmed) + 1);
    CHECK(sentences.count("unknown") == 0);
  }

  TEST_CASE("no frames, few frames and a short span are told apart") {
    const PointWorld world(drone(1));
    const ImuHistory imu;
    CHECK(guess_start({}, imu, world.rig(), start_config()).refusal == StartRefusal::kTooFewFrames);
    CHECK(guess(world, start_frames(world, 0, 0.1)).refusal == StartRefusal::kTooFewFrames);
    CHECK(guess(world, start_frames(world, 0, 0.3)).refusal == StartRefusal::kTooShort);
  }

  TEST_CASE("frames without inertial data are refused for that reason") {
    const PointWorld world(drone(1));
    const auto imu = std::make_unique<ImuHistory>();
    const StartFrames frames = start_frames(world, 0, 1.0);
    CHECK(guess_start(frames, *imu, world.rig(), start_config()).refusal == StartRefusal::kNoImu);
  }

  TEST_CASE("a hole in the inertial data is refused for that reason") {
    const PointWorld world(drone(1));
    const auto imu = std::make_unique<ImuHistory>();
    const StartFrames frames = start_frames(world, 0, 1.0);
    const Timestamp hole = frames.front().t + Duration::from_ms(400);
    for (const ImuSample& s : world.imu())
      if (s.t < hole || s.t > hole + Duration::from_ms(100)) imu->add(s);
    CHECK(guess_start(frames, *imu, world.rig(), start_config()).refusal == StartRefusal::kImuGap);
  }

  TEST_CASE("too few points are refused for that reason") {
    PointWorldOptions options = drone(1);
    options.points = 4;
    options.max_track_frames = 1000;
    const PointWorld world(options);
    CHECK(guess(world, start_frames(world, 0, 1.0)).refusal == StartRefusal::kTooFewTracks);
  }

  TEST_CASE("gravity read in the wrong unit is never accepted") {
    PointWorldOptions options = drone(1);
    options.motion = MotionKind::kStill;
    const PointWorld world(options);
    const StartFrames frames = start_frames(world, 0, 1.0);
    const auto imu = std::make_unique<ImuHistory>();
    for (ImuSample s : world.imu()) {
      for (double& a : s.accel_mps2) a /= 9.81;
      imu->add(s);
    }
    CHECK(guess_start(frames, *imu, world.rig(), start_config()).refusal == StartRefusal::kGravity);
  }

  TEST_CASE("bearings that are not finite do not reach the states") {
    const PointWorld world(drone(3));
    StartFrames frames = start_frames(world, 0, 1.0);
    for (FrameMeasurement& frame : frames)
      frame.points[0].bearing_xy[0] = std::numeric_limits<double>::quiet_NaN();
    const StartGuess g = guess(world, frames);
    REQUIRE(g.refusal == StartRefusal::kNone);
    for (const NavState& s : g.states) CHECK(s.p_wb.allFinite());
  }

  TEST_CASE("the first state is at the origin with yaw zero and there is one state per frame") {
    const PointWorld world(drone(2));
    const StartFrames frames = start_frames(world, 0, 1.0);
    const StartGuess g = guess(world, frames);
    REQUIRE(g.refusal == StartRefusal::kNone);
    REQUIRE(g.states.size() == frames.size());
    CHECK(g.states.front().p_wb.norm() < 1e-12);
    const Eigen::Vector3d x = g.states.front().q_wb * Eigen::Vector3d::UnitX();
    CHECK(x.y() == doctest::Approx(0).epsilon(1e-9));
    CHECK(x.x() > 0);
    for (std::size_t k = 0; k < frames.size(); ++k) CHECK(g.states[k].t == frames[k].t);
  }

  TEST_CASE("the same frames give the same bits") {
    const PointWorld world(drone(4));
    const StartFrames frames = start_frames(world, 5, 0.8);
    const StartGuess a = guess(world, frames);
    const StartGuess b = guess(world, frames);
    REQUIRE(a.refusal == StartRefusal::kNone);
    CHECK(a.scale_sigma == b.scale_sigma);
    for (std::size_t k = 0; k < a.states.size(); ++k) {
      CHECK(a.states[k].p_wb == b.states[k].p_wb);
      CHECK(a.states[k].q_wb.coeffs() == b.states[k].q_wb.coeffs());
    }
  }
}
