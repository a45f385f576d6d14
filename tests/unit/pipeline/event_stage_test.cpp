#include "pled_vins/pipeline/event_stage.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "support/pipeline/stage_cases.hpp"

namespace pled {
namespace {

using namespace support;

double quantile(const std::vector<double>& sorted, double share) {
  REQUIRE(!sorted.empty());
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

TEST_SUITE("pipeline.event_stage") {
  TEST_CASE("points are followed as the scene moves, in both pictures and through a lens") {
    for (const bool distorted : {false, true}) {
      const RigCalibration rig = event_rig(distorted);
      const EventScene scene(rig.cameras[0], 0.12, 1);
      const std::vector<Event> events = scene.events(swing(), kStart_us, kStart_us + 1'000'000);
      for (const EventPicture picture : kPictures) {
        CAPTURE(distorted);
        CAPTURE(static_cast<int>(picture));
        StageRun run(config_of(picture), rig, swing());
        run.play(events, kStart_us, kStart_us + 1'000'000);
        const std::vector<double> errors = run.steps_off_px(scene);
        CHECK(errors.size() > 60);
        CHECK(quantile(errors, 0.5) < 1.0);
        std::uint32_t longest = 0;
        for (const FrameMeasurement& m : run.history())
          for (const PointMeasurement& p : m.points) longest = std::max(longest, p.track_length);
        CHECK(longest >= (picture == EventPicture::kBrightness ? 12U : 4U));
        CHECK(run.stage().counts().still_pictures == 0);
        CHECK(run.stage().counts().shed == 0);
        MESSAGE("steps " << errors.size() << ", median off " << quantile(errors, 0.5)
                         << " px, longest track " << longest);
      }
    }
  }

  TEST_CASE("bearings are those of the raw pixels") {
    const RigCalibration rig = event_rig(true);
    const Camera camera(rig.cameras[0]);
    const EventScene scene(rig.cameras[0], 0.12, 1);
    const std::vector<Event> events = scene.events(swing(), kStart_us, kStart_us + 300'000);
    for (const EventPicture picture : kPictures) {
      StageRun run(config_of(picture), rig, swing());
      run.play(events, kStart_us, kStart_us + 300'000);
      REQUIRE(run.measured().points.size() > 5);
      for (const PointMeasurement& p : run.measured().points) {
        CHECK(p.kind == FeatureKind::kEventPoint);
        const Eigen::Vector2d raw = camera.distort({p.bearing_xy[0], p.bearing_xy[1]});
        CHECK(p.raw_px[0] == doctest::Approx(raw.x()).epsilon(1e-6));
        CHECK(p.raw_px[1] == doctest::Approx(raw.y()).epsilon(1e-6));
      }
      CHECK(run.measured().t.us == kStart_us + 300'000);
      CHECK(run.measured().stamp_ns == (kStart_us + 300'000) * 1000);
    }
  }

  TEST_CASE("lines get their own kind of picture, as points would, and change nothing for them") {
    const RigCalibration rig = event_rig(true);
    const EventScene scene(rig.cameras[0], 0.12, 3);
    const std::vector<Event> events = scene.events(swing(), kStart_us, kStart_us + 300'000);
    for (const EventPicture of_points : kPictures)
      for (const EventPicture of_lines : kPictures)
        for (const int max_points : {0, 60}) {
          CAPTURE(static_cast<int>(of_points));
          CAPTURE(static_cast<int>(of_lines));
          CAPTURE(max_points);
          EventStageConfig config = config_of(of_points);
          config.events.max_points = max_points;
          StageRun without(config, rig, swing());
          config.line_picture = of_lines;
          StageRun with(config, rig, swing());
          StageRun like_points(config_of(of_lines), rig, swing());
          for (StageRun* run : {&without, &with, &like_points})
            run->play(events, kStart_us, kStart_us + 300'000);
          CHECK(without.stage().line_picture().empty());
          for (std::size_t k = 0; k < with.history().size(); ++k)
            check_same(with.history()[k], without.history()[k]);
          const auto picture = with.stage().line_picture();
          const auto want = like_points.stage().picture();
          REQUIRE(picture.width == want.width);
          REQUIRE(picture.height == want.height);
          std::size_t grey_levels = 0;
          std::array<bool, 256> seen{};
          bool same = true;
          for (int y = 0; y < want.height; ++y)
            for (int x = 0; x < want.width; ++x) {
              same = same && picture.at(y, x) == want.at(y, x);
              grey_levels += seen[want.at(y, x)] ? 0U : 1U;
              seen[want.at(y, x)] = true;
            }
          CHECK(same);
          CHECK(grey_levels > 20);
        }
  }

  TEST_CASE("how events are split into calls makes no difference to the points") {
    const RigCalibration rig = event_rig(true);
    const EventScene scene(rig.cameras[0], 0.12, 2);
    const std::vector<Event> events = scene.events(swing(), kStart_us, kStart_us + 400'000);
    for (const EventPicture picture : kPictures) {
      StageRun whole(config_of(picture), rig, swing());
      whole.play(events, kStart_us, kStart_us + 400'000);
      for (const std::size_t packet : {std::size_t{1}, std::size_t{333}}) {
        StageRun split(config_of(picture), rig, swing(), {.packet = packet});
        split.play(events, kStart_us, kStart_us + 400'000);
        REQUIRE(split.history().size() == whole.history().size());
        for (std::size_t k = 0; k < whole.history().size(); ++k)
          check_same(split.history()[k], whole.history()[k]);
      }
    }
  }

  TEST_CASE("how events are split into calls, and how early the gyro is, leaves the map as it is") {
    const RigCalibration rig = event_rig(true);
    const EventScene scene(rig.cameras[0], 0.12, 2);
    const std::vector<Event> events = scene.events(swing(), kStart_us, kStart_us + 250'000);
    const EventStageConfig config = config_of(EventPicture::kBrightness, true);
    StageRun whole(config, rig, swing());
    whole.play(events, kStart_us, kStart_us + 250'000);
    for (const std::size_t packet : {std::size_t{1}, std::size_t{77}, std::size_t{3001}}) {
      for (const bool gyro_by_packet : {false, true}) {
        CAPTURE(packet);
        CAPTURE(gyro_by_packet);
        StageRun split(config, rig, swing(), {.packet = packet, .gyro_by_packet = gyro_by_packet});
        split.play(events, kStart_us, kStart_us + 250'000);
        CHECK(split.stage().counts().without_turn == whole.stage().counts().without_turn);
        std::size_t pixels = 0;
        std::size_t differing = 0;
        for (double x = -0.5; x < 0.5; x += 0.01)
          for (double y = -0.4; y < 0.4; y += 0.01) {
            const auto score = [&](StageRun& run) {
              return run.stage().score({x, y, 1}, ScorePooling::kPixel, ScoreForm::kClean);
            };
            const auto a = score(whole);
            const auto b = score(split);
            pixels += a ? 1U : 0U;
            const bool same =
                a.has_value() == b.has_value() && (!a || (a->n == b->n && a->s == b->s));
            differing += same ? 0U : 1U;
          }
        CHECK(pixels > 500);
        CHECK(differing == 0);
      }
    }
  }

  TEST_CASE("a burst is shed beyond the rate and counted to the event") {
    const RigCalibration rig = event_rig(false);
    EventStageConfig config = config_of(EventPicture::kBrightness);
    config.events.max_rate_mevps = 0.5;  // 500 in 1.024 ms
    StageRun run(config, rig, {});
    std::mt19937_64 random(1);
    std::vector<Event> events;
    for (std::int64_t i = 0; i < 6000; ++i)  // all of one slot
      events.push_back({{kStart_us + i / 10},
                        static_cast<std::uint16_t>(random() % 160),
                        static_cast<std::uint16_t>(random() % 120),
                        Polarity::kOn});
    run.observe(kStart_us + 50'000, events);
    CHECK(run.stage().counts().shed == 5500);
    CHECK(run.stage().counts().surface.in == 500);
  }

  TEST_CASE("no events at all are no points and no fault") {
    for (const EventPicture picture : kPictures) {
      StageRun run(config_of(picture, true), event_rig(true), swing());
      run.play({}, kStart_us, kStart_us + 300'000);
      for (const FrameMeasurement& m : run.history()) CHECK(m.points.size() == 0);
      CHECK_FALSE(run.stage().score({0, 0, 1}, ScorePooling::kPixel, ScoreForm::kPaper));
      CHECK(run.stage().counts().surface.in == 0);
      CHECK(run.stage().counts().without_turn == 0);
    }
  }

  TEST_CASE(
      "without a gyro pictures are drawn as they are, the map stays empty; both are counted") {
    const RigCalibration rig = event_rig(false);
    const EventScene scene(rig.cameras[0], 0.12, 5);
    const std::vector<Event> events = scene.events(swing(), kStart_us, kStart_us + 300'000);
    for (const EventPicture picture : kPictures) {
      CAPTURE(static_cast<int>(picture));
      StageRun run(config_of(picture, true), rig, swing(), {.gyro = false});
      run.play(events, kStart_us, kStart_us + 300'000);
      CHECK(run.stage().counts().still_pictures ==
            (picture == EventPicture::kTimeSurface ? run.history().size() : 0));
      CHECK(run.stage().counts().without_turn == events.size());
      CHECK(run.measured().points.size() > 5);
      for (const PointMeasurement& p : run.measured().points)
        CHECK_FALSE(run.stage().score({p.bearing_xy[0], p.bearing_xy[1], 1.0}, ScorePooling::kPixel,
                                      ScoreForm::kPaper));
    }
  }

  TEST_CASE("an event camera elsewhere on the body, with a clock of its own, is followed as well") {
    RigCalibration rig = event_rig(true);
    rig.num_cameras = 2;
    rig.cameras[1] = rig.cameras[0];
    rig.cameras[1].T_body_cam = {so3::exp({0.1, -0.15, 0.8}), {0.03, -0.02, 0.05}};
    rig.cameras[1].time_shift_s = 0.008192;
    rig.event_camera = 1;
    const EventScene scene(rig.cameras[1], 0.12, 7);
    const std::vector<Event> on_body_clock = scene.events(swing(), kStart_us, kStart_us + 600'000);
    const std::vector<Event> events = with_stamps_moved(on_body_clock, -8192);
    for (const EventPicture picture : kPictures) {
      CAPTURE(static_cast<int>(picture));
      StageRun run(config_of(picture), rig, swing());
      CHECK(run.stage().time_shift() == Duration{8192});
      run.play(events, kStart_us, kStart_us + 600'000);
      for (const PointMeasurement& p : run.measured().points) CHECK(p.camera == 1);
      const std::vector<double> errors = run.steps_off_px(scene);
      CHECK(errors.size() > 40);
      CHECK(quantile(errors, 0.5) < 1.0);
      CHECK(run.measured().t.us == kStart_us + 600'000);

      // The same with stamps that need no shift: times are whole bins and slices apart.
      RigCalibration no_shift = rig;
      no_shift.cameras[1].time_shift_s = 0.0;
      StageRun same(config_of(picture), no_shift, swing());
      same.play(on_body_clock, kStart_us, kStart_us + 600'000);
      check_same(run.measured(), same.measured());
    }
  }

  TEST_CASE("no points are looked for when none are wanted, and the map works all the same") {
    EventStageConfig config = config_of(EventPicture::kBrightness, true);
    config.events.max_points = 0;
    const RigCalibration rig = event_rig(false);
    StageRun run(config, rig, {});
    run.observe(kStart_us + 50'000, {});
    std::vector<Event> events;
    for (std::int64_t i = 0; i < 5; ++i)
      events.push_back({{kStart_us + 80'000 + 4000 * i}, 82, 58, Polarity::kOn});
    run.observe(kStart_us + 100'000, events);
    CHECK(run.measured().points.size() == 0);
    const Eigen::Vector3d ray(0.0, (58 - rig.cameras[0].cy_px) / rig.cameras[0].fy_px, 1.0);
    const auto score = run.stage().score(ray, ScorePooling::kPixel, ScoreForm::kPaper);
    REQUIRE(score);
    CHECK(score->n == 5);
  }
}

}  // namespace pled
