// What is lost on the way into the map is told with the other losses of events.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/pipeline/vio_pipeline.hpp"
#include "support/pipeline/stage_run.hpp"

namespace pled {
namespace {

class NoSolver final : public WindowSolver {
 public:
  SolveSummary solve(const WindowProblem&, const SolveOptions&) noexcept override { return {}; }
};

/// Events and inertial data, no frames.
struct Line {
  Line() {
    EventStageConfig config;
    config.keep_map = true;
    stage = std::make_unique<EventStage>(config, rig, storage->view());
    PipelineOptions options;
    options.use_frames = false;
    options.score = TemporalScore::kPaper;
    pipeline =
        std::make_unique<VioPipeline>(rig, *imu, *tracker, *backend, health, options, stage.get());
  }

  void turn(std::int64_t from_us, std::int64_t to_us, double rate_radps) {
    for (std::int64_t t = from_us; t <= to_us; t += 5000)
      pipeline->on_imu({{t}, {0, rate_radps, 0}, {0, 0, 9.81}});
  }
  void observe(std::int64_t t_us, const std::vector<Event>& events) {
    FrameView frame;
    frame.t = Timestamp{t_us};
    pipeline->expect(frame);
    pipeline->on_events(events);
    FrameResult result;
    REQUIRE(pipeline->on_frame(frame, result));
  }

  RigCalibration rig = support::event_rig(false);
  NoSolver solver;
  Health health;
  std::unique_ptr<ImuHistory> imu = std::make_unique<ImuHistory>();
  std::unique_ptr<FrameTrackerStorage<160, 120>> tracker_storage =
      std::make_unique<FrameTrackerStorage<160, 120>>();
  std::unique_ptr<FrameTracker> tracker = std::make_unique<FrameTracker>(
      FrontendConfig{}, Camera(rig.cameras[0]), tracker_storage->view());
  std::unique_ptr<Backend> backend = std::make_unique<Backend>(BackendConfig{}, rig, solver);
  std::unique_ptr<support::EventStorage> storage = std::make_unique<support::EventStorage>();
  std::unique_ptr<EventStage> stage;
  std::unique_ptr<VioPipeline> pipeline;
};

/// One event a millisecond, at the right border.
std::vector<Event> at_border(std::int64_t from_us, std::int64_t to_us) {
  std::vector<Event> out;
  for (std::int64_t t = from_us; t < to_us; t += 1000)
    out.push_back({{t}, static_cast<std::uint16_t>(158 + t / 1000 % 2), 60, Polarity::kOn});
  return out;
}

}  // namespace

TEST_SUITE("pipeline.event_losses") {
  TEST_CASE("events that the camera's turning carries out of the map are told, across a reset") {
    Line line;
    line.turn(1'000'000, 1'300'000, 6.0);
    line.observe(1'200'000, at_border(1'100'000, 1'200'000));
    const std::uint64_t lost = line.stage->counts().map.outside;
    CHECK(lost > 0);
    CHECK(line.health.faults(Fault::kEventMapOutside) == lost);
    CHECK(to_string(Fault::kEventMapOutside) == "event_map_outside");
    line.stage->reset();
    CHECK(line.stage->counts().map.outside == lost);
    Line still;
    still.turn(1'000'000, 1'300'000, 0.0);
    still.observe(1'200'000, at_border(1'100'000, 1'200'000));
    CHECK(still.health.faults(Fault::kEventMapOutside) == 0);
  }

  TEST_CASE("a hole of the gyro is told") {
    Line line;
    line.turn(1'000'000, 1'300'000, 0.1);
    line.observe(1'200'000, {});
    CHECK(line.health.faults(Fault::kEventTurnGap) == 0);
    line.turn(1'380'000, 1'700'000, 0.1);
    line.observe(1'600'000, {});
    CHECK(line.health.faults(Fault::kEventTurnGap) == 1);
    CHECK(line.health.faults(Fault::kEventTurnDropped) == 0);
  }

  TEST_CASE("every fault has a name of its own") {
    std::vector<std::string> names;
    for (int k = 0; k < static_cast<int>(Fault::kCount); ++k) {
      names.emplace_back(to_string(static_cast<Fault>(k)));
      CHECK(names.back() != "unknown");
    }
    std::sort(names.begin(), names.end());
    CHECK(std::adjacent_find(names.begin(), names.end()) == names.end());
  }
}

}  // namespace pled
