#include "pled_vins/pipeline/vio_pipeline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/backend/solvers.hpp"
#include "pled_vins/frontend/lines/line_image.hpp"
#include "pled_vins/frontend/lines/segment_finder.hpp"
#include "src/apps/allocation_counter.hpp"
#include "support/frontend/tracked_scene.hpp"
#include "support/pipeline/event_scene.hpp"

namespace pled {
namespace {

std::uint64_t allocations() { return apps::allocation_count().value_or(0); }

/// Ceres allocates; what it allocates is put aside.
class UncountedSolver final : public WindowSolver {
 public:
  SolveSummary solve(const WindowProblem& problem, const SolveOptions& options) noexcept override {
    const std::uint64_t before = allocations();
    const SolveSummary summary = inner_->solve(problem, options);
    put_aside_ += allocations() - before;
    ++solves_;
    return summary;
  }
  [[nodiscard]] std::uint64_t put_aside() const { return put_aside_; }
  [[nodiscard]] int solves() const { return solves_; }

 private:
  std::unique_ptr<WindowSolver> inner_ = make_solver(SolverKind::kFixed);
  std::uint64_t put_aside_ = 0;
  int solves_ = 0;
};

constexpr double kFramePeriod_s = 0.05;
constexpr double kImuPeriod_s = 0.005;
constexpr double kStillUntil_s = 1.0;

/// Along the camera's x: stands, then swings 0.4 m to and fro in 2 s; y points down.
struct Motion {
  double x_m = 0.0;
  double accel_mps2 = 0.0;
  explicit Motion(double t_s) {
    const double u = t_s - kStillUntil_s;
    if (u <= 0) return;
    constexpr double kRate_radps = std::numbers::pi;
    // 3 - 4 cos + cos 2: value, velocity and acceleration start at zero.
    x_m = 0.05 * (3 - 4 * std::cos(kRate_radps * u) + std::cos(2 * kRate_radps * u));
    accel_mps2 = 0.05 * kRate_radps * kRate_radps *
                 (4 * std::cos(kRate_radps * u) - 4 * std::cos(2 * kRate_radps * u));
  }
};

struct Path {
  [[nodiscard]] Pose pose(double t_s) const { return support::pose_at(Motion(t_s).x_m, 0, -1); }
};

ImuSample imu_at(double t_s) {
  ImuSample s;
  s.t = Timestamp{} + Duration::from_s(t_s);
  s.accel_mps2 = {Motion(t_s).accel_mps2, -9.81, 0.0};
  return s;
}

RigCalibration rig_of(const Camera& camera) {
  RigCalibration rig;
  rig.num_cameras = 1;
  rig.cameras[0] = camera.calibration();
  rig.imu = {.accel_density = 0.002,
             .accel_walk = 0.003,
             .gyro_density = 0.00017,
             .gyro_walk = 2e-5,
             .rate_hz = 1.0 / kImuPeriod_s};
  return rig;
}

/// How often OpenCV's line detector goes to the heap for a picture, the only one that may.
std::uint64_t of_line_detector(ImageView<const std::uint8_t> picture, bool is_time_surface) {
  static LineStorage<240, 180> storage;
  if (is_time_surface) {
    const ImageView<std::uint8_t> filtered{storage.filtered.data(), 240, 180, 240};
    median_3x3(picture, filtered);
    picture = filtered;
  }
  const ImageView<std::uint8_t> shrunk{storage.shrunk.data(), shrunk_px(240), shrunk_px(180),
                                       shrunk_px(240)};
  shrink(picture, storage.row, shrunk);
  std::array<ShrunkPiece, limits::kMaxSegments> pieces;
  std::size_t found = 0;
  const std::uint64_t before = allocations();
  const LineConfig config;
  const double shortest_px = config.min_length_share * 180.0;
  REQUIRE(find_pieces(shrunk, kLineScale * shortest_px / 3.0, pieces, found));
  return allocations() - before;
}

/// Flies along with everything on: points from events drawn as `picture`, the map, all scores,
/// lines of frames and of events drawn the other way.
void fly_without_heap(EventPicture picture) {
  const Camera camera = support::davis240_camera(true);
  const support::PlaneScene scene(camera, support::Texture(1, 0.04, 0.5));
  const RigCalibration rig = rig_of(camera);
  const auto storage = std::make_unique<support::Storage240>();
  const auto tracker = std::make_unique<FrameTracker>(FrontendConfig{}, camera, storage->view());
  const auto imu = std::make_unique<ImuHistory>();
  UncountedSolver solver;
  const auto backend = std::make_unique<Backend>(BackendConfig{}, rig, solver);
  const auto health = std::make_unique<Health>();
  const auto event_storage = std::make_unique<EventStageStorage<240, 180>>();
  EventStageConfig event_config;
  event_config.events.picture = picture;
  event_config.keep_map = true;
  LineStageConfig line_config;
  line_config.source = LineSource::kBoth;
  line_config.event_picture =
      picture == EventPicture::kBrightness ? EventPicture::kTimeSurface : EventPicture::kBrightness;
  event_config.line_picture = line_config.event_picture;
  const auto stage = std::make_unique<EventStage>(event_config, rig, event_storage->view());
  const auto line_storage = std::make_unique<LineStorage<240, 180>>();
  const auto lines = std::make_unique<LineStage>(line_config, rig, line_storage->view());
  PipelineOptions options;
  options.all_scores = true;
  const auto pipeline = std::make_unique<VioPipeline>(rig, *imu, *tracker, *backend, *health,
                                                      options, stage.get(), lines.get());
  const std::vector<Event> events =
      support::EventScene(rig.cameras[0], 0.15, 1).events(Path{}, 0, 3'500'000);
  std::span<const Event> left(events);
  std::mt19937_64 random(1);
  int poses = 0;
  int imu_samples = 0;
  double farthest_m = 0.0;
  std::size_t event_points = 0;
  std::size_t event_lines = 0;
  std::size_t frame_lines = 0;
  std::size_t known_scores = 0;
  for (int k = 1; k < 70; ++k) {
    const double t_s = k * kFramePeriod_s;
    const auto image = scene.render(support::pose_at(Motion(t_s).x_m, 0, -1), 180, 30, 1.0, random);
    FrameView frame;
    frame.t = Timestamp{} + Duration::from_s(t_s);
    frame.stamp_ns = frame.t.us * 1000;
    frame.image = image.view();
    FrameResult result;
    std::size_t n = 0;
    while (n < left.size() && left[n].t <= frame.t) ++n;

    const std::uint64_t before = allocations() - solver.put_aside();
    for (; imu_samples * kImuPeriod_s <= t_s + kImuPeriod_s; ++imu_samples)
      pipeline->on_imu(imu_at(imu_samples * kImuPeriod_s));
    pipeline->expect(frame);
    pipeline->on_events(left.first(n));
    const bool processed = pipeline->on_frame(frame, result);
    const std::uint64_t after = allocations() - solver.put_aside();

    CAPTURE(k);
    REQUIRE(processed);
    const std::uint64_t by_detector =
        of_line_detector(frame.image, false) +
        of_line_detector(stage->line_picture(),
                         line_config.event_picture == EventPicture::kTimeSurface);
    if (k > 1) CHECK(after - before == by_detector);  // OpenCV sets itself up once
    for (const LineMeasurement& line : result.measurement->lines)
      ++(line.id >= kFirstEventLineId ? event_lines : frame_lines);
    left = left.subspan(n);
    for (const PointMeasurement& p : result.measurement->points)
      event_points += p.kind == FeatureKind::kEventPoint && p.track_length > 2 ? 1U : 0U;
    for (const TemporalWeights& w : result.temporal)
      known_scores += std::isnan(w.paper) || std::isnan(w.motion) ? 0U : 1U;
    if (!result.backend->has_pose) continue;
    ++poses;
    farthest_m = std::max(farthest_m,
                          Eigen::Vector3d::Map(result.backend->pose.p_world_body_m.data()).norm());
  }
  // All of it took part: start, tracking, keyframes and marginalisation over 0.4 m.
  CHECK(poses > 40);
  CHECK(solver.solves() > 40);
  CHECK(farthest_m > 0.3);
  CHECK(farthest_m < 0.5);
  CHECK(event_points > 100);
  CHECK(known_scores > 100);
  CHECK(event_lines > 100);
  CHECK(frame_lines > 10);
}

}  // namespace

TEST_SUITE("pipeline.vio_pipeline.memory") {
  TEST_CASE(
      "a frame and its events go to a pose without the heap, but for solver and line detector") {
    if (!apps::allocation_count()) {
      MESSAGE("skipped: the sanitizer owns the heap");
      return;
    }
    const std::uint64_t start = allocations();
    void* volatile block = std::malloc(1);  // volatile: else the compiler leaves both out
    std::free(block);
    REQUIRE(allocations() > start);  // the hook works
    for (const EventPicture picture : {EventPicture::kBrightness, EventPicture::kTimeSurface}) {
      CAPTURE(static_cast<int>(picture));
      fly_without_heap(picture);
    }
  }
}

}  // namespace pled
