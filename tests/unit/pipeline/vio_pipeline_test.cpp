#include "pled_vins/pipeline/vio_pipeline.hpp"

#include <cmath>
#include <memory>
#include <random>
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include "support/pipeline/stage_run.hpp"

namespace pled {
namespace {

constexpr std::int64_t kStart_us = 1 << 20;
constexpr std::int64_t kFrame_us = 50'000;

/// Nothing starts here: what goes in and what is measured is looked at.
class NoSolver final : public WindowSolver {
 public:
  SolveSummary solve(const WindowProblem&, const SolveOptions&) noexcept override { return {}; }
};

support::SwingingBody swing() { return {{0.15, 0.25, 0.2}, {0.12, 0.08, 0.02}, 0.6}; }

/// A pipeline with its stages, and a wall of squares before a swinging body.
class Rig {
 public:
  Rig(bool use_frames, bool with_events, LineSource lines = LineSource::kNone)
      : rig_(support::event_rig(true)),
        scene_(rig_.cameras[0], 0.12, 1),
        events_(scene_.events(swing(), kStart_us, kStart_us + 8 * kFrame_us)),
        picture_(160 * 120) {
    LineStageConfig line_config;
    line_config.source = lines;
    line_config.event_picture = EventPicture::kTimeSurface;  // not what points are followed in
    line_config.tracking.min_length_share = 0.03;
    if (lines != LineSource::kNone)
      line_stage_ = std::make_unique<LineStage>(line_config, rig_, line_storage_->view());
    EventStageConfig config;
    if (from_events(lines)) config.line_picture = line_config.event_picture;
    if (with_events) stage_ = std::make_unique<EventStage>(config, rig_, event_storage_->view());
    PipelineOptions options;
    options.use_frames = use_frames;
    pipeline_ = std::make_unique<VioPipeline>(rig_, *imu_, *tracker_, *backend_, health_, options,
                                              stage_.get(), line_stage_.get());
    std::mt19937_64 random(1);
    for (std::size_t y = 0; y < 120; y += 6)
      for (std::size_t x = 0; x < 160; x += 8) {
        const auto grey = static_cast<std::uint8_t>(random() % 256);
        for (std::size_t i = 0; i < 48; ++i) picture_[(y + i / 8) * 160 + x + i % 8] = grey;
      }
  }

  [[nodiscard]] FrameView frame(int k, bool with_image, std::int64_t offset_us = 0) const {
    FrameView f;
    f.t = Timestamp{kStart_us + k * kFrame_us + offset_us};
    f.stamp_ns = f.t.us * 1000 + 7;
    if (with_image) f.image = {picture_.data(), 160, 120, 160};
    return f;
  }

  /// Everything up to frame k, and the frame; all stamps `offset_us` later.
  bool play(int k, bool with_image, FrameResult& result, std::int64_t offset_us = 0) {
    const FrameView f = frame(k, with_image, offset_us);
    const std::int64_t t_us = kStart_us + k * kFrame_us;
    for (std::int64_t t = t_us - kFrame_us; t <= t_us; t += 5000) {
      if (t == t_us - kFrame_us && k > 1) continue;  // came with the frame before
      const Eigen::Vector3d w = swing().gyro_radps(static_cast<double>(t) * 1e-6);
      pipeline_->on_imu({{t + offset_us}, {w.x(), w.y(), w.z()}, {0, 0, 9.81}});
    }
    pipeline_->expect(f);
    std::vector<Event> share;
    for (const Event& e : events_)
      if (e.t.us > t_us - kFrame_us && e.t.us <= t_us) {
        share.push_back(e);
        share.back().t.us += offset_us;
      }
    pipeline_->on_events(share);
    sent_ += share.size();
    return pipeline_->on_frame(f, result);
  }
  [[nodiscard]] VioPipeline& pipeline() { return *pipeline_; }
  [[nodiscard]] const Health& health() const { return health_; }
  [[nodiscard]] std::uint64_t sent() const { return sent_; }

 private:
  RigCalibration rig_;
  support::EventScene scene_;
  std::vector<Event> events_;
  std::vector<std::uint8_t> picture_;
  NoSolver solver_;
  Health health_;
  std::unique_ptr<ImuHistory> imu_ = std::make_unique<ImuHistory>();
  std::unique_ptr<FrameTrackerStorage<160, 120>> storage_ =
      std::make_unique<FrameTrackerStorage<160, 120>>();
  std::unique_ptr<FrameTracker> tracker_ =
      std::make_unique<FrameTracker>(FrontendConfig{}, Camera(rig_.cameras[0]), storage_->view());
  std::unique_ptr<Backend> backend_ = std::make_unique<Backend>(BackendConfig{}, rig_, solver_);
  std::unique_ptr<support::EventStorage> event_storage_ = std::make_unique<support::EventStorage>();
  std::unique_ptr<EventStage> stage_;
  std::unique_ptr<LineStorage<160, 120>> line_storage_ = std::make_unique<LineStorage<160, 120>>();
  std::unique_ptr<LineStage> line_stage_;
  std::unique_ptr<VioPipeline> pipeline_;
  std::uint64_t sent_ = 0;
};

std::size_t count(const FrameMeasurement& m, FeatureKind kind) {
  std::size_t n = 0;
  for (const PointMeasurement& p : m.points) n += p.kind == kind ? 1U : 0U;
  return n;
}

/// 1 when both are the same weight, 0 when both are none.
std::size_t told(double w, double given_out) {
  CHECK((w == given_out || (std::isnan(w) && std::isnan(given_out))));
  return std::isnan(w) ? 0 : 1;
}

}  // namespace

TEST_SUITE("pipeline.vio_pipeline") {
  TEST_CASE("points of both kinds come in one measurement, each with its own id and a weight") {
    Rig rig(true, true);
    for (int k = 1; k <= 6; ++k) {
      FrameResult result;
      REQUIRE(rig.play(k, true, result));
      const FrameMeasurement& m = *result.measurement;
      CHECK(count(m, FeatureKind::kImagePoint) > 20);
      if (k > 2) CHECK(count(m, FeatureKind::kEventPoint) > 5);
      std::set<FeatureId> ids;
      for (const PointMeasurement& p : m.points) ids.insert(p.id);
      CHECK(ids.size() == m.points.size());
      CHECK(result.temporal.size() == m.points.size());
      CHECK(result.backend->weights.size() == m.points.size());
    }
    CHECK(rig.health().events.in == rig.sent());
    CHECK(rig.health().events.used + rig.health().events.dropped == rig.sent());
  }

  TEST_CASE("without frames their times are enough, and all points come from events") {
    Rig rig(false, true);
    for (int k = 1; k <= 6; ++k) {
      FrameResult result;
      REQUIRE(rig.play(k, false, result));
      const FrameMeasurement& m = *result.measurement;
      CHECK(m.t == rig.frame(k, false).t);
      CHECK(m.stamp_ns == rig.frame(k, false).stamp_ns);
      CHECK(count(m, FeatureKind::kImagePoint) == 0);
      if (k < 3) continue;
      CHECK(m.points.size() > 5);
      CHECK(m.median_flow_px > 0.1);  // the events' own
    }
    CHECK(rig.health().faults(Fault::kFrameWrongSize) == 0);
  }

  TEST_CASE("a frame without an image is refused when frames are to be used") {
    Rig rig(true, true);
    FrameResult result;
    CHECK_FALSE(rig.play(1, false, result));
    CHECK(rig.health().faults(Fault::kFrameWrongSize) == 1);
    CHECK(rig.health().frames.dropped == 1);
  }

  TEST_CASE("without an event stage events are counted and not looked at") {
    Rig rig(true, false);
    FrameResult result;
    for (int k = 1; k <= 3; ++k) REQUIRE(rig.play(k, true, result));
    CHECK(rig.health().events.in == rig.sent());
    CHECK(rig.sent() > 1000);
    CHECK(count(*result.measurement, FeatureKind::kEventPoint) == 0);
  }

  TEST_CASE("lines come beside the points, of what is looked at, and change none of them") {
    for (const bool use_frames : {true, false}) {
      CAPTURE(use_frames);
      Rig with(use_frames, true, LineSource::kBoth);
      Rig without(use_frames, true);
      std::size_t of_frames = 0;
      std::size_t of_events = 0;
      std::size_t knowing = 0;
      for (int k = 1; k <= 6; ++k) {
        FrameResult a, b;
        REQUIRE(with.play(k, use_frames, a));
        REQUIRE(without.play(k, use_frames, b));
        CHECK(b.measurement->lines.empty());
        for (const LineMeasurement& line : a.measurement->lines)
          ++(line.id >= kFirstEventLineId ? of_events : of_frames);
        REQUIRE(a.temporal_lines.size() == a.measurement->lines.size());
        REQUIRE(a.temporal.size() == a.measurement->points.size());
        // What the back end is told is what is given out, no evidence included.
        for (std::size_t i = 0; i < a.temporal_lines.size(); ++i)
          knowing += told(a.measurement->lines[i].w_temporal, a.temporal_lines[i].motion);
        for (std::size_t i = 0; i < a.temporal.size(); ++i)
          knowing += told(a.measurement->points[i].w_temporal, a.temporal[i].motion);
        REQUIRE(a.measurement->points.size() == b.measurement->points.size());
        for (std::size_t i = 0; i < a.measurement->points.size(); ++i) {
          CHECK(a.measurement->points[i].raw_px == b.measurement->points[i].raw_px);
          CHECK(a.measurement->points[i].for_solver == b.measurement->points[i].for_solver);
        }
      }
      CHECK(of_events > 10);
      if (use_frames) CHECK(knowing > 10);  // points tell the camera's way
      CHECK((of_frames > 10) == use_frames);
      CHECK(with.health().stage(Stage::kLines).count() == 6);
      CHECK(without.health().stage(Stage::kLines).count() == 0);
      CHECK(with.health().faults(Fault::kLinePictureSkipped) == 0);
    }
  }

  TEST_CASE("after a clock jump points and lines begin as if nothing had been seen") {
    for (const bool use_frames : {false, true}) {
      CAPTURE(use_frames);
      Rig jumped(use_frames, true, LineSource::kBoth);
      Rig fresh(use_frames, true, LineSource::kBoth);
      FrameResult result;
      for (int k = 1; k <= 3; ++k) REQUIRE(jumped.play(k, use_frames, result, 900'000'000));
      REQUIRE(result.measurement->points.size() > 5);
      REQUIRE(result.measurement->lines.size() > 1);
      jumped.pipeline().on_clock_jump();
      for (int k = 1; k <= 3; ++k) {
        FrameResult a, b;
        REQUIRE(jumped.play(k, use_frames, a));
        REQUIRE(fresh.play(k, use_frames, b));
        REQUIRE(a.measurement->points.size() == b.measurement->points.size());
        for (std::size_t i = 0; i < a.measurement->points.size(); ++i) {
          CHECK(a.measurement->points[i].raw_px == b.measurement->points[i].raw_px);
          CHECK(a.measurement->points[i].track_length == b.measurement->points[i].track_length);
        }
        REQUIRE(a.measurement->lines.size() == b.measurement->lines.size());
        for (std::size_t i = 0; i < a.measurement->lines.size(); ++i) {
          CHECK(a.measurement->lines[i].raw_px == b.measurement->lines[i].raw_px);
          CHECK(a.measurement->lines[i].track_length == b.measurement->lines[i].track_length);
        }
      }
    }
  }
}

}  // namespace pled
