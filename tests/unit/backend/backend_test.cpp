#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <doctest/doctest.h>

#include "tests/support/simulated_run.hpp"

namespace pled {
namespace {

using support::MotionKind;
using support::PointWorld;
using support::PointWorldOptions;
using support::run_world;
using support::RunFigures;
using support::SimulatedRun;

BackendConfig config_for(const PointWorldOptions& options) {
  BackendConfig config;
  config.point_sigma_px = options.pixel_sigma;
  return config;
}

PointWorldOptions standing(std::uint64_t seed) {
  PointWorldOptions options;
  options.motion = MotionKind::kStill;
  options.seed = seed;
  options.duration_s = 4;
  options.max_track_frames = 200;  // a standing camera sees the same points again and again
  return options;
}

/// Largest distance of a pose from the first; infinity when fewer than half of the frames have one.
double farthest_from_first_m(const PointWorldOptions& options) {
  const PointWorld world(options);
  SimulatedRun run(world, config_for(options));
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  std::size_t poses = 0;
  double farthest_m = 0;
  for (std::size_t k = 0; k < world.frames().size(); ++k) {
    const BackendOutput& out = run.step(k);
    if (!out.has_pose) continue;
    const Eigen::Vector3d p(out.pose.p_world_body_m.data());
    if (poses++ == 0) first = p;
    farthest_m = std::max(farthest_m, (p - first).norm());
  }
  return 2 * poses > world.frames().size() ? farthest_m : std::numeric_limits<double>::infinity();
}

/// From `from_s` after the first frame to the end: how wrong the way and the turn are, and how
/// often the rig was taken to stand.
struct Moved {
  double error_rad = std::numeric_limits<double>::infinity();
  double still_share = 0;
};

Moved moved_after(const PointWorldOptions& options, double from_s) {
  const PointWorld world(options);
  SimulatedRun run(world, config_for(options));
  const Timestamp from = world.frames()[0].t + Duration::from_s(from_s);
  std::optional<NavState> first;
  double frames = 0, still = 0;
  for (std::size_t k = 0; k < world.frames().size(); ++k) {
    const BackendOutput& out = run.step(k);
    if (world.frames()[k].t < from) continue;
    if (!out.has_pose) return {};
    if (!first) first = run.backend().window().newest().x;
    frames += 1;
    still += run.backend().window().newest().still ? 1 : 0;
  }
  const NavState last = run.backend().window().newest().x;
  const NavState a = world.truth(first->t), b = world.truth(last.t);
  const Eigen::Quaterniond turn = first->q_wb.conjugate() * last.q_wb;
  return {turn.angularDistance(a.q_wb.conjugate() * b.q_wb), still / frames};
}

/// Stands for 2 s, then moves; every second seed has its motors on.
PointWorldOptions moving_off(MotionKind motion, std::uint64_t seed) {
  PointWorldOptions options;
  options.seed = seed;
  options.motion = motion;
  options.still_until_s = 2;
  options.duration_s = 8;
  options.vibration_mps2 = seed % 2 == 0 ? 1.5 : 0.0;
  return options;
}

/// Most solver steps of a frame, before and from `at_s` after the first pose.
struct Steps {
  int before = 0;
  int after = 0;
};

Steps most_steps(const PointWorldOptions& options, double at_s) {
  const PointWorld world(options);
  SimulatedRun run(world, config_for(options));
  std::optional<Timestamp> first;
  Steps most;
  for (std::size_t k = 0; k < world.frames().size(); ++k) {
    const BackendOutput& out = run.step(k);
    if (!out.has_pose) continue;
    const Timestamp t = world.frames()[k].t;
    if (!first) first = t;
    int& steps = t - *first < Duration::from_s(at_s) ? most.before : most.after;
    steps = std::max(steps, out.iterations);
  }
  return most;
}

}  // namespace

TEST_SUITE("backend.backend") {
  TEST_CASE("the solver takes fewer steps once the rig has moved for two seconds") {
    const BackendConfig config;
    REQUIRE(config.settled_iterations < config.max_iterations);
    PointWorldOptions options;
    options.duration_s = 6;
    const Steps moving = most_steps(options, 2.1);
    CHECK(moving.before > config.settled_iterations);
    CHECK(moving.before <= config.max_iterations);
    CHECK(moving.after == config.settled_iterations);
    // What stands for 2 s has its scale to find when it moves off.
    options.motion = MotionKind::kCreep;
    options.mean_speed_mps = 0.5;
    options.still_until_s = 3;
    CHECK(most_steps(options, 3.0).after > config.settled_iterations);
  }

  TEST_CASE("a drone is started within 1.5 s and followed to 2 cm") {
    PointWorldOptions options;
    options.duration_s = 6;
    const PointWorld world(options);
    SimulatedRun run(world, config_for(options));
    const RunFigures figures = run_world(world, run);
    CHECK(figures.first_pose_s >= 0);
    CHECK(figures.first_pose_s <= 1.5);
    CHECK(figures.rmse_m < 0.02);
    CHECK(figures.resets == 0);
  }

  TEST_CASE("a rig that stands stays within 2 cm") {
    PointWorldOptions options;
    options.motion = MotionKind::kStill;
    options.duration_s = 4;
    CHECK(farthest_from_first_m(options) < 0.02);
  }

  TEST_CASE("a rig that stands with its motors on stays within 2 cm, whenever it is started") {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
      CAPTURE(seed);
      PointWorldOptions options = standing(seed);
      options.vibration_mps2 = 1.5;
      CHECK(farthest_from_first_m(options) < 0.02);
      CHECK(moved_after(options, 1.0).still_share > 0.9);
    }
  }

  TEST_CASE("a rig that creeps at 5 cm/s is not held still, with motors on or off") {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
      CAPTURE(seed);
      PointWorldOptions options = moving_off(MotionKind::kCreep, seed);
      options.mean_speed_mps = 0.05;
      options.min_depth_m = 2;
      // Half a second after it moved off it has gone 5 mm.
      CHECK(moved_after(options, 2.7).still_share == 0);
    }
  }

  TEST_CASE("a rig that turns on the spot at 3 deg/s is not held still, with motors on or off") {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
      CAPTURE(seed);
      const PointWorldOptions options = moving_off(MotionKind::kPan, seed);
      const Moved moved = moved_after(options, 2.5);
      CHECK(moved.still_share == 0);
      CHECK(moved.error_rad < 0.021);  // of 0.28 rad
    }
  }

  TEST_CASE("a body of three quarters of the points that drives off does not take the pose along") {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
      CAPTURE(seed);
      PointWorldOptions options;
      options.seed = seed;
      options.duration_s = 6;
      options.moving_share = 0.75;
      options.moving_together = true;
      options.moving_from_s = 3;
      const PointWorld world(options);
      SimulatedRun run(world, config_for(options));
      const RunFigures figures = run_world(world, run);
      CHECK(figures.rmse_m < 0.03);
      CHECK(figures.resets == 0);
    }
  }

  TEST_CASE("points that move on their own are given less weight and do not carry the pose away") {
    PointWorldOptions options;
    options.duration_s = 5;
    options.moving_share = 0.3;
    const PointWorld world(options);
    SimulatedRun run(world, config_for(options));
    const RunFigures figures = run_world(world, run);
    CHECK(figures.rmse_m < 0.05);
    CHECK(figures.weight_moving < 0.5 * figures.weight_static);
  }

  TEST_CASE(
      "over a hole of half a second in the IMU the output frame goes on, and the reset is told") {
    PointWorldOptions options;
    options.duration_s = 5;
    const PointWorld world(options);
    SimulatedRun run(world, config_for(options));
    run.lost = [](const ImuSample& s) { return s.t.seconds() > 4.0 && s.t.seconds() < 4.5; };
    const RunFigures figures = run_world(world, run);
    CHECK(figures.resets == 1);
    CHECK(run.backend().faults().imu_gaps == 1);
    CHECK(figures.rmse_m < 0.1);
    CHECK(run.backend().tracking());
  }

  TEST_CASE("the same input gives the same bits") {
    PointWorldOptions options;
    options.duration_s = 2;
    const PointWorld world(options);
    SimulatedRun a(world, config_for(options)), b(world, config_for(options));
    for (std::size_t k = 0; k < world.frames().size(); ++k) {
      const PoseEstimate& x = a.step(k).pose;
      const PoseEstimate& y = b.step(k).pose;
      REQUIRE(x.p_world_body_m == y.p_world_body_m);
      REQUIRE(x.q_world_body_xyzw == y.q_world_body_xyzw);
    }
  }

  TEST_CASE("every point is answered: gated ones with 0, those without evidence with NaN") {
    PointWorldOptions options;
    options.duration_s = 1;
    const PointWorld world(options);
    SimulatedRun run(world, config_for(options));
    run.backend().start_from(world.truth(world.frames()[0].t), Vector15d::Constant(0.01));
    (void)run.step(0);
    auto imu = std::make_unique<ImuHistory>();
    for (const ImuSample& s : world.imu()) imu->add(s);
    FrameMeasurement frame = world.frames()[1];
    frame.points[0].inlier = false;
    BackendOutput out;
    run.backend().process(frame, *imu, out);
    REQUIRE(out.weights.size() == frame.points.size());
    CHECK(out.weights[0].w == 0.0);
    CHECK_FALSE(out.weights[0].used);
    CHECK(std::isnan(out.weights[1].w_geometric));  // seen twice: not yet in the solver
    CHECK(out.weights[1].observations == 2);
  }

  TEST_CASE("a frame that is not newer than the last is refused and changes nothing") {
    PointWorldOptions options;
    options.duration_s = 1;
    const PointWorld world(options);
    SimulatedRun run(world, config_for(options));
    run.backend().start_from(world.truth(world.frames()[0].t), Vector15d::Constant(0.01));
    (void)run.step(0);
    (void)run.step(1);
    auto imu = std::make_unique<ImuHistory>();
    for (const ImuSample& s : world.imu()) imu->add(s);
    BackendOutput out;
    run.backend().process(world.frames()[0], *imu, out);
    CHECK_FALSE(out.has_pose);
    CHECK(run.backend().faults().frames_refused == 1);
    CHECK(run.backend().window().size() == 2);
  }
}

}  // namespace pled
