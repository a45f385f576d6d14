#include "pled_vins/pipeline/event_scores.hpp"

#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "support/pipeline/stage_run.hpp"

namespace pled {
namespace {

using support::StageRun;
using support::SwingingBody;

constexpr std::int64_t kObserved_us = 1'300'000;
constexpr std::int64_t kWindow_us = 8 * 4096;
const Eigen::Vector3d kRayOf82_58(0.0, -0.5 / 130.0, 1.0);  ///< of the camera without lens errors

EventStageConfig map_only() {
  EventStageConfig config;
  config.events.max_points = 0;
  config.keep_map = true;
  return config;
}

/// Where the camera has a direction of the world at a time.
Eigen::Vector3d ray_of(const SwingingBody& body, const CameraCalibration& camera,
                       const Eigen::Vector3d& direction, std::int64_t t_us) {
  const Eigen::Quaterniond R_world_cam =
      body.pose(static_cast<double>(t_us) * 1e-6).q * camera.T_body_cam.q;
  return R_world_cam.conjugate() * direction;
}

}  // namespace

TEST_SUITE("pipeline.event_scores") {
  TEST_CASE("a direction keeps its events however the camera turns, and others get none") {
    for (const bool second_camera : {false, true}) {
      for (const double turn_rad : {0.0, 0.1, 0.6}) {
        CAPTURE(second_camera);
        CAPTURE(turn_rad);
        RigCalibration rig = support::event_rig(true);
        if (second_camera) {
          rig.num_cameras = 2;
          rig.cameras[1] = rig.cameras[0];
          rig.cameras[1].T_body_cam = {so3::exp({0.2, -0.3, 0.9}), {0.05, 0.02, -0.01}};
          rig.cameras[1].time_shift_s = -0.0123;
          rig.event_camera = 1;
        }
        const CameraCalibration& camera = rig.cameras[rig.event_camera];
        const Camera lens(camera);
        const SwingingBody body{turn_rad * Eigen::Vector3d(0.3, 1.0, 0.2).normalized(),
                                Eigen::Vector3d::Zero(), 0.4};
        // A source that blinks in the middle of the picture, when it is observed.
        const Eigen::Vector3d direction = body.pose(kObserved_us * 1e-6).q * camera.T_body_cam.q *
                                          Eigen::Vector3d(0.05, -0.08, 1.0).normalized();
        std::vector<Event> events;
        std::size_t in_window = 0;
        for (std::int64_t t = kObserved_us - 150'000; t <= kObserved_us; t += 1700) {
          const auto px = lens.project(ray_of(body, camera, direction, t));
          REQUIRE(px);
          events.push_back({{t - std::llround(camera.time_shift_s * 1e6)},
                            static_cast<std::uint16_t>(std::lround(px->x())),
                            static_cast<std::uint16_t>(std::lround(px->y())),
                            Polarity::kOn});
          in_window += t > kObserved_us - kWindow_us ? 1 : 0;
        }
        StageRun run(map_only(), rig, body);
        run.play(events, kObserved_us - 150'000, kObserved_us);

        const auto events_near = [&](double dx, double dy) {
          // The blinking pixel is rounded twice, at the sensor and in the map: 3 x 3 hold it all.
          std::uint32_t n = 0;
          for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x) {
              Eigen::Vector3d ray = ray_of(body, camera, direction, kObserved_us);
              ray /= ray.z();
              ray += Eigen::Vector3d((dx + x) / camera.fx_px, (dy + y) / camera.fy_px, 0);
              const auto score = run.stage().score(ray, ScorePooling::kPixel, ScoreForm::kPaper);
              n += score ? score->n : 0;
            }
          return n;
        };
        CHECK(run.stage().counts().without_turn == 0);
        CHECK(events_near(0, 0) == in_window);
        CHECK(events_near(8, 0) == 0);
        CHECK(events_near(0, -8) == 0);
      }
    }
  }

  TEST_CASE("rays behind the camera and beyond the map have no evidence") {
    const RigCalibration rig = support::event_rig(false);
    StageRun run(map_only(), rig, {});
    std::vector<Event> events;
    for (int x = 0; x < 160; ++x)
      events.push_back({{kObserved_us - 1000}, static_cast<std::uint16_t>(x), 58, Polarity::kOn});
    run.observe(kObserved_us - 50'000, {});
    run.observe(kObserved_us, events);
    const auto known = [&](const Eigen::Vector3d& ray) {
      return run.stage().score(ray, ScorePooling::kMostEvents, ScoreForm::kClean).has_value();
    };
    CHECK(known({0, 0, 1}));
    CHECK(known({0, 0, 3}));
    CHECK_FALSE(known({0, 0, -1}));
    CHECK_FALSE(known({0, 0, 0}));
    CHECK_FALSE(known({5, 0, 1}));
    CHECK_FALSE(known({0, 0.3, 1}));
    CHECK_FALSE(known({std::nan(""), 0, 1}));
  }

  TEST_CASE("the window of an announced frame ends with it, though frames come at uneven times") {
    const RigCalibration rig = support::event_rig(false);
    StageRun run(map_only(), rig, {});
    const auto events_at = [](std::int64_t observed_us,
                              const std::vector<std::int64_t>& before_us) {
      std::vector<Event> events;
      for (const std::int64_t before : before_us)
        events.push_back({{observed_us - before}, 82, 58, Polarity::kOn});
      return events;
    };
    run.observe(kObserved_us - 93'000, events_at(kObserved_us - 93'000, {100}));
    run.observe(kObserved_us - 43'000, events_at(kObserved_us - 43'000, {100}));
    run.observe(kObserved_us, events_at(kObserved_us, {kWindow_us, kWindow_us - 1, 20'000, 100}));
    const auto score = run.stage().score(kRayOf82_58, ScorePooling::kPixel, ScoreForm::kPaper);
    REQUIRE(score);
    CHECK(score->n == 3);
  }

  TEST_CASE("only events of the window before the observation count") {
    const RigCalibration rig = support::event_rig(false);
    StageRun run(map_only(), rig, {});
    run.observe(kObserved_us - 100'000, {});
    run.observe(kObserved_us - 50'000, {});
    std::vector<Event> events;
    for (const std::int64_t before_us : {49'000L, 40'000L, kWindow_us, kWindow_us - 1, 5000L, 0L})
      events.push_back({{kObserved_us - before_us}, 82, 58, Polarity::kOn});
    run.observe(kObserved_us, events);
    const auto score = run.stage().score(kRayOf82_58, ScorePooling::kPixel, ScoreForm::kPaper);
    REQUIRE(score);
    CHECK(score->n == 3);  // a bin owns its end, not its begin
  }
}

}  // namespace pled
