#include "pled_vins/pipeline/line_cues.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"
#include "pled_vins/pipeline/temporal_cues.hpp"
#include "support/pipeline/stage_run.hpp"

namespace pled {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::int64_t kFrame_us = 50'000;
constexpr std::int64_t kBin_us = 4096;
constexpr double kBeside1 = 0.726149037;  // exp(-1 / 2 sigma^2), sigma = 5 / 4
constexpr double kBeside2 = 0.278037300;

/// Cues, a map, and a body that turns at a constant rate.
struct Bench {
  explicit Bench(const Vector3d& rate_radps = Vector3d::Zero())
      : rig(support::event_rig(false)), camera(rig.cameras[0]), rate(rate_radps) {
    for (std::int64_t t = 0; t <= 2'000'000; t += 5000)
      imu->add({{t}, {rate.x(), rate.y(), rate.z()}, {0, 0, rig.imu.gravity_mps2}});
    EventStageConfig config;
    config.events.max_points = 0;
    config.keep_map = true;
    stage = std::make_unique<EventStage>(config, rig, storage->view());
    cues = std::make_unique<TemporalCues>(MotionCueConfig{}, rig, true);
  }

  [[nodiscard]] static Timestamp time(int k) { return {1'000'000 + k * kFrame_us}; }

  /// A line between two pixels, as it is seen in frame k.
  [[nodiscard]] FrameMeasurement frame(int k, const Vector2d& start_px,
                                       const Vector2d& end_px) const {
    FrameMeasurement f;
    f.t = time(k);
    LineMeasurement line;
    line.id = kFirstImageLineId;
    for (std::size_t i = 0; i < 2; ++i) {
      const Vector2d px = i == 0 ? start_px : end_px;
      line.raw_px[i] = {px.x(), px.y()};
      const Vector2d at = camera.undistort(px).value();
      line.bearing_xy[i] = {at.x(), at.y()};
    }
    (void)f.lines.push_back(line);
    return f;
  }

  /// Shows events (bin of the window, pixel) and observes at frame k.
  struct Spot {
    int bin;
    Vector2d px;
  };
  void observe(int k, std::vector<Spot> spots) {
    std::stable_sort(spots.begin(), spots.end(),
                     [](const Spot& a, const Spot& b) { return a.bin < b.bin; });
    std::vector<Event> events;
    for (const Spot& s : spots)
      events.push_back({time(k) - Duration{(7 - s.bin) * kBin_us + 100},
                        static_cast<std::uint16_t>(std::lround(s.px.x())),
                        static_cast<std::uint16_t>(std::lround(s.px.y())), Polarity::kOn});
    stage->follow_turn(*imu, Vector3d::Zero());
    stage->expect(time(k));
    stage->on_events(events);
    FrameMeasurement none;
    stage->observe(time(k), 0, std::nullopt, none);
  }

  void judge(const FrameMeasurement& f, bool with_map) {
    (void)cues->judge(f, *imu, std::nullopt, Vector3d::Zero(), with_map ? stage.get() : nullptr);
  }

  RigCalibration rig;
  Camera camera;
  Vector3d rate;
  std::unique_ptr<ImuHistory> imu = std::make_unique<ImuHistory>();
  std::unique_ptr<support::EventStorage> storage = std::make_unique<support::EventStorage>();
  std::unique_ptr<EventStage> stage;
  std::unique_ptr<TemporalCues> cues;
};

/// Row y of pixels 40 to 80, in the given bins.
std::vector<Bench::Spot> row(int y, const std::vector<int>& bins) {
  std::vector<Bench::Spot> out;
  for (const int bin : bins)
    for (int x = 40; x <= 80; ++x) out.push_back({bin, {x, y}});
  return out;
}

}  // namespace

TEST_SUITE("pipeline.line_cues") {
  TEST_CASE("the map is read along a line: to the letter for paper, where events are for count") {
    Bench bench;
    bench.judge(bench.frame(0, {40, 60}, {80, 60}), false);
    bench.observe(0, {{7, {5, 5}}});  // from here on bins end at frames
    bench.observe(1, row(60, {0, 1, 2, 3, 4, 5, 6, 7}));
    FrameMeasurement f = bench.frame(1, {40, 60}, {80, 60});
    bench.judge(f, true);
    REQUIRE(bench.cues->lines().size() == 1);
    const TemporalWeights& w = bench.cues->lines()[0];
    CHECK(w.paper ==
          doctest::Approx(1.0 - 1.0 / (1.0 + 2 * kBeside1 + 2 * kBeside2)).epsilon(1e-6));
    CHECK(w.count == doctest::Approx(0.5));  // eight events
    CHECK(std::isnan(w.motion));             // nobody knows the camera's way
    bench.cues->write(TemporalScore::kPaper, f);
    CHECK(f.lines[0].w_temporal == w.paper);
    bench.cues->write(TemporalScore::kCount, f);
    CHECK(f.lines[0].w_temporal == w.count);
    CHECK(f.lines[0].alpha_line == kUnknownAlpha);  // it did not move
    bench.cues->write(TemporalScore::kMotion, f);
    CHECK(std::isnan(f.lines[0].w_temporal));
  }

  TEST_CASE("where no event is, or no map is read, lines have no evidence of it") {
    Bench bench;
    bench.judge(bench.frame(0, {40, 60}, {80, 60}), false);
    bench.observe(1, row(30, {0, 3, 7}));
    FrameMeasurement f = bench.frame(1, {40, 60}, {80, 60});
    for (const bool with_map : {true, false}) {
      bench.judge(f, with_map);
      CHECK(std::isnan(bench.cues->lines()[0].paper));
      CHECK(std::isnan(bench.cues->lines()[0].count));
      bench.cues->write(TemporalScore::kCount, f);
      CHECK(std::isnan(f.lines[0].w_temporal));
      CHECK(std::isnan(f.lines[0].alpha_line));
    }
  }

  TEST_CASE("alpha comes from where the line was and the gradient of q along its band") {
    for (const bool gradient : {false, true}) {
      CAPTURE(gradient);
      Bench bench;
      // 4 px down since the last frame, its ends where they were.
      bench.judge(bench.frame(0, {45, 56}, {75, 56}), false);
      std::vector<Bench::Spot> spots;
      for (int y = 56; y <= 63; ++y) {
        if (!gradient && y != 60) continue;
        const auto more = row(y, {y - 56});
        spots.insert(spots.end(), more.begin(), more.end());
      }
      bench.observe(1, spots);
      FrameMeasurement f = bench.frame(1, {45, 60}, {75, 60});
      bench.judge(f, true);
      // p_n = 4 / 4.1; a single row has no gradient that both neighbours would show.
      bench.cues->write(TemporalScore::kCount, f);
      const double p_n = 4.0 / 4.1;
      CHECK(f.lines[0].alpha_line ==
            doctest::Approx(gradient ? 1.0 : 1.0 - p_n).epsilon(gradient ? 0.01 : 1e-6));
      bench.cues->write(TemporalScore::kPaper, f);
      // Up to it and down from it q is as steep: r = 0, p_n = 1.
      CHECK(f.lines[0].alpha_line == doctest::Approx(gradient ? 1.0 : 0.0).epsilon(1e-6));
      bench.judge(f, true);  // the same once more: it has not moved
      bench.cues->write(TemporalScore::kCount, f);
      CHECK(f.lines[0].alpha_line == kUnknownAlpha);
      // A line that was not there in the last frame.
      f.lines[0].id += 7;
      bench.judge(f, true);
      bench.cues->write(TemporalScore::kPaper, f);
      CHECK(std::isnan(f.lines[0].alpha_line));
    }
  }

  TEST_CASE("what the camera's turning does to a line is not its motion") {
    const Vector3d rate(0.8, 0.0, 0.3);
    Bench turning(rate);
    const Vector2d start(45, 60), end(75, 60);
    // Where directions of the world, now at these pixels, were one frame ago.
    const Eigen::Quaterniond R_then_now = so3::exp(rate * 1e-6 * kFrame_us);
    const auto then = [&](const Vector2d& px) -> Vector2d {
      const Vector3d ray = R_then_now * turning.camera.undistort(px).value().homogeneous();
      return turning.camera.project(ray).value();
    };
    REQUIRE((then(start) - start).norm() > 4.0);
    const auto alpha = [&](Bench& bench, const Vector2d& from, const Vector2d& to) {
      bench.judge(bench.frame(0, from, to), false);
      bench.observe(1, row(60, {7, 7}));
      FrameMeasurement f = bench.frame(1, start, end);
      bench.judge(f, true);
      bench.cues->write(TemporalScore::kCount, f);
      return f.lines[0].alpha_line;
    };
    CHECK(alpha(turning, then(start), then(end)) == kUnknownAlpha);
    // One that stays in the picture moves, here across itself, and nothing says where q grows.
    Bench with_it(rate);
    CHECK(alpha(with_it, start, end) < 0.2);
  }

  TEST_CASE("reset forgets where lines were") {
    Bench bench;
    bench.judge(bench.frame(0, {45, 50}, {75, 50}), false);
    bench.observe(1, row(60, {1, 2, 3}));
    bench.cues->reset();
    CHECK(bench.cues->lines().empty());
    FrameMeasurement f = bench.frame(1, {45, 60}, {75, 60});
    bench.judge(f, true);
    bench.cues->write(TemporalScore::kCount, f);
    CHECK(f.lines[0].w_temporal == doctest::Approx(8.0 / 11.0));
    CHECK(std::isnan(f.lines[0].alpha_line));
  }
}

}  // namespace pled
