#include <cmath>

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

}  // namespace

TEST_SUITE("backend.backend") {
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
    const PointWorld world(options);
    SimulatedRun run(world, config_for(options));
    Eigen::Vector3d first = Eigen::Vector3d::Constant(std::nan(""));
    std::size_t poses = 0;
    for (std::size_t k = 0; k < world.frames().size(); ++k) {
      const BackendOutput& out = run.step(k);
      if (!out.has_pose) continue;
      const Eigen::Vector3d p(out.pose.p_world_body_m.data());
      if (poses++ == 0) first = p;
      CHECK((p - first).norm() < 0.02);
    }
    CHECK(poses > world.frames().size() / 2);
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
