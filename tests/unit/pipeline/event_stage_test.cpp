#include "pled_vins/pipeline/event_stage.hpp"

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "support/pipeline/stage_run.hpp"

namespace pled {
namespace {

using support::event_rig;
using support::EventScene;
using support::StageRun;
using support::SwingingBody;

constexpr std::int64_t kStart_us = 1 << 20;  ///< the swing starts at 0: it is fast by then

EventStageConfig config_of(EventPicture picture, bool keep_map = false) {
  EventStageConfig config;
  config.events.picture = picture;
  config.events.max_points = 60;
  config.keep_map = keep_map;
  return config;
}

/// Turns and goes sideways at once: at most 0.67 rad/s and 0.28 m/s before a wall at 1 m.
SwingingBody swing() { return {{0.15, 0.25, 0.2}, {0.12, 0.08, 0.02}, 0.6}; }

constexpr std::array kPictures{EventPicture::kBrightness, EventPicture::kTimeSurface};

void check_same(const FrameMeasurement& a, const FrameMeasurement& b) {
  REQUIRE(a.points.size() == b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    const PointMeasurement& p = a.points[i];
    const PointMeasurement& q = b.points[i];
    CHECK(p.id == q.id);
    CHECK(p.raw_px == q.raw_px);
    CHECK(p.bearing_xy == q.bearing_xy);
    CHECK(p.track_length == q.track_length);
  }
}

double quantile(const std::vector<double>& sorted, double share) {
  REQUIRE(!sorted.empty());
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

std::vector<Event> with_stamps_moved(std::vector<Event> events, std::int64_t by_us) {
  for (Event& e : events) e.t.us += by_us;
  return events;
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

  TEST_CASE("times around 2^32 microseconds are times like others") {
    const RigCalibration rig = event_rig(false);
    const EventScene scene(rig.cameras[0], 0.12, 3);
    const std::vector<Event> events = scene.events(swing(), kStart_us, kStart_us + 600'000);
    for (const EventPicture picture : kPictures) {
      CAPTURE(static_cast<int>(picture));
      StageRun early(config_of(picture, true), rig, swing());
      early.play(events, kStart_us, kStart_us + 600'000);
      // 2^32 us pass 0.26 s after the first event; a multiple of all periods, so nothing else
      // moves.
      const std::int64_t offset_us = (std::int64_t{1} << 32) - kStart_us - (1 << 18);
      StageRun late(config_of(picture, true), rig, swing(), {.offset_us = offset_us});
      late.play(events, kStart_us, kStart_us + 600'000);
      for (std::size_t k = 0; k < early.history().size(); ++k) {
        CAPTURE(k);
        check_same(late.history()[k], early.history()[k]);
      }
      REQUIRE(early.measured().points.size() > 10);
      int scores = 0;
      for (const PointMeasurement& p : early.measured().points) {
        const Eigen::Vector3d ray(p.bearing_xy[0], p.bearing_xy[1], 1.0);
        const auto a = early.stage().score(ray, ScorePooling::kPixel, ScoreForm::kPaper);
        const auto b = late.stage().score(ray, ScorePooling::kPixel, ScoreForm::kPaper);
        REQUIRE(a.has_value() == b.has_value());
        if (!a) continue;
        ++scores;
        CHECK(b->n == a->n);
        CHECK(b->s == doctest::Approx(a->s));
      }
      CHECK(scores > 0);
    }
  }

  TEST_CASE("events whose stamps go back are counted and change no point") {
    const RigCalibration rig = event_rig(false);
    const EventScene scene(rig.cameras[0], 0.12, 4);
    const std::vector<Event> events = scene.events(swing(), kStart_us, kStart_us + 300'000);
    std::vector<Event> dirty;
    std::uint64_t strange = 0;
    for (std::size_t i = 0; i < events.size(); ++i) {
      dirty.push_back(events[i]);
      if (i % 100 != 99 || events[i].t.us - events[0].t.us < 5000) continue;
      Event back = events[i - 50];
      back.t.us = events[i].t.us - 3000;
      dirty.push_back(back);
      ++strange;
    }
    REQUIRE(strange > 50);
    for (const EventPicture picture : kPictures) {
      StageRun clean(config_of(picture), rig, swing());
      StageRun noisy(config_of(picture), rig, swing());
      // Packets as an observation would cut them, whatever the stamps say.
      for (StageRun* run : {&clean, &noisy}) {
        const std::vector<Event>& all = run == &clean ? events : dirty;
        std::size_t begin = 0;
        for (std::int64_t t = kStart_us + 50'000; t <= kStart_us + 300'000; t += 50'000) {
          std::size_t end = begin;
          while (end < all.size() && all[end].t.us <= t) ++end;
          run->observe(t, std::span(all).subspan(begin, end - begin));
          begin = end;
        }
      }
      CHECK(noisy.stage().counts().surface.strange_stamp == strange);
      check_same(noisy.measured(), clean.measured());
      CHECK(clean.measured().points.size() > 5);
    }
  }

  TEST_CASE("a picture of events whose clock was set back shows nothing from before") {
    const RigCalibration rig = event_rig(false);
    const EventScene scene(rig.cameras[0], 0.12, 4);
    const std::vector<Event> events = scene.events(swing(), kStart_us, kStart_us + 50'000);
    for (const std::size_t packet : {std::size_t{0}, std::size_t{1}, std::size_t{64}}) {
      CAPTURE(packet);
      StageRun run(config_of(EventPicture::kBrightness), rig, {},
                   {.gyro = false, .packet = packet});
      const auto shown = [&run] {
        const auto picture = run.stage().picture();
        std::size_t n = 0;
        for (int y = 0; y < picture.height; ++y)
          for (int x = 0; x < picture.width; ++x) n += picture.at(y, x) != 128 ? 1U : 0U;
        return n;
      };
      run.observe(kStart_us + 50'000, events);
      REQUIRE(shown() > 100);
      // 63 are taken for strange; the next restarts the surface. One pixel fires, too slowly for a
      // hot one.
      std::vector<Event> after = events;
      constexpr std::int64_t kBack_us = 100'000'000;
      for (int k = 0; k < 70; ++k)
        after.push_back({{kStart_us - kBack_us + 10'000 * k}, 80, 60, Polarity::kOn});
      for (Event& e : std::span(after).first(events.size())) e.t.us += 50'000;
      run.observe(kStart_us - kBack_us + 700'000, after);
      CHECK(run.stage().counts().surface.restarts == 1);
      CHECK(run.stage().counts().surface.strange_stamp == 63);
      CHECK(shown() == 1);
      CHECK(run.stage().picture().at(60, 80) > 128);
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

  TEST_CASE("after reset() it works on another clock as a new one does") {
    const RigCalibration rig = event_rig(false);
    const EventScene scene(rig.cameras[0], 0.12, 6);
    const std::vector<Event> events = scene.events(swing(), kStart_us, kStart_us + 300'000);
    for (const EventPicture picture : kPictures) {
      StageRun fresh(config_of(picture, true), rig, swing());
      fresh.play(events, kStart_us, kStart_us + 300'000);

      EventStageConfig config = config_of(picture, true);
      auto storage = std::make_unique<support::EventStorage>();
      EventStage stage(config, rig, storage->view());
      FrameMeasurement out;
      const auto drive = [&](std::int64_t offset_us) {
        // By hand, since the other clock is another history of the gyro.
        ImuHistory imu;
        std::span<const Event> left(events);
        std::optional<std::int64_t> last;
        std::int64_t sample_us = kStart_us + 50'000 - 200 * 4096;
        for (std::int64_t t = kStart_us + 50'000; t <= kStart_us + 300'000; t += 50'000) {
          for (; sample_us - 4096 <= t; sample_us += 4096) {
            const Eigen::Vector3d w = swing().gyro_radps(static_cast<double>(sample_us) * 1e-6);
            (void)imu.add({{sample_us + offset_us}, {w.x(), w.y(), w.z()}, {0, 0, 9.81}});
          }
          stage.follow_turn(imu, Eigen::Vector3d::Zero());
          stage.expect({t + offset_us});
          std::vector<Event> share;
          for (; !left.empty() && left.front().t.us <= t; left = left.subspan(1))
            share.push_back(left.front());
          stage.on_events(with_stamps_moved(share, offset_us));
          std::optional<Eigen::Quaterniond> R;
          if (last) R = fresh.pose(*last).q.conjugate() * fresh.pose(t).q;
          stage.observe({t + offset_us}, 0, R, out);
          last = t;
        }
      };
      drive(std::int64_t{1} << 40);
      stage.reset();
      out = {};
      drive(0);
      REQUIRE(out.points.size() == fresh.measured().points.size());
      for (std::size_t i = 0; i < out.points.size(); ++i) {
        const PointMeasurement& p = out.points[i];
        CHECK(p.raw_px == fresh.measured().points[i].raw_px);
        CHECK(p.track_length == fresh.measured().points[i].track_length);
        const Eigen::Vector3d ray(p.bearing_xy[0], p.bearing_xy[1], 1.0);
        const auto a = stage.score(ray, ScorePooling::kPixel, ScoreForm::kPaper);
        const auto b = fresh.stage().score(ray, ScorePooling::kPixel, ScoreForm::kPaper);
        REQUIRE(a.has_value() == b.has_value());
        if (a) CHECK(a->n == b->n);
      }
      stage.reset();
      CHECK_FALSE(stage.score({0, 0, 1}, ScorePooling::kMostEvents, ScoreForm::kPaper));
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

  TEST_CASE("a clock that is corrected is followed as one that was calibrated so") {
    RigCalibration told = event_rig(true);
    told.cameras[0].time_shift_s = 0.008192;
    const EventScene scene(told.cameras[0], 0.12, 7);
    const std::vector<Event> events =
        with_stamps_moved(scene.events(swing(), kStart_us, kStart_us + 600'000), -8192);
    for (const EventPicture picture : kPictures) {
      CAPTURE(static_cast<int>(picture));
      StageRun calibrated(config_of(picture), told, swing());
      StageRun corrected(config_of(picture), event_rig(true), swing());
      corrected.stage().correct_clock(Duration{8192});
      CHECK(corrected.stage().time_shift() == Duration{8192});
      calibrated.play(events, kStart_us, kStart_us + 600'000);
      corrected.play(events, kStart_us, kStart_us + 600'000);
      CHECK(corrected.measured().points.size() > 10);
      check_same(corrected.measured(), calibrated.measured());
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
