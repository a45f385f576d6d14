// What the event stage makes of stamps: wraps, steps back, other clocks.
#include <cmath>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/pipeline/event_stage.hpp"
#include "support/pipeline/stage_cases.hpp"

namespace pled {
namespace {

using namespace support;

}  // namespace

TEST_SUITE("pipeline.event_stage.clock") {
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
}

}  // namespace pled
