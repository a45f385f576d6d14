#include "pled_vins/sim/simulator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <new>
#include <vector>

#include "pled_vins/sim/imu_model.hpp"
#include "src/sim/bus.hpp"
#include "src/sim/clearance.hpp"
#include "src/sim/event_model.hpp"
#include "src/sim/parallel.hpp"
#include "src/sim/random.hpp"
#include "src/sim/recording_writer.hpp"
#include "src/sim/step_planner.hpp"

namespace pled::sim {
namespace {

constexpr double kTruthRateHz = 200.0;
constexpr double kFramesShare = 0.2;       // of the progress; events take the rest
constexpr std::size_t kFramesAtOnce = 16;  // exposed in parallel, then written in order
constexpr std::size_t kRendersAtOnce = 8;
constexpr double kPlanReserve = 0.85;

/// One run: what all its parts look at.
struct Run {
  const SimulationOptions& options;
  const World& world;
  const Renderer& renderer;        ///< of the frames
  const Renderer& event_renderer;  ///< of the events
  const Trajectory& trajectory;
  RecordingWriter& writer;
  const ProgressCallback& progress;

  void report(double share) const {
    if (progress) progress(share);
  }
};

/// The frames that are kept, in order.
std::vector<ListedFrame> list_frames(const SimulationOptions& o) {
  const auto count = static_cast<std::size_t>(o.duration_s * o.frames.rate_hz - 1e-6) + 1;
  Random random = stream(o.seed, Stream::kFaults);
  std::vector<ListedFrame> frames;
  for (std::size_t k = 0; k < count; ++k) {
    const bool dropped = random.uniform() < o.faults.dropped_share;
    const double stamp_s = static_cast<double>(k) / o.frames.rate_hz + o.faults.camera_late_s;
    if (!dropped && stamp_s >= 0.0) frames.push_back({k, stamp_s});
  }
  return frames;
}

Result<std::uint64_t> write_frames(const Run& run) {
  const std::vector<ListedFrame> listed = list_frames(run.options);
  std::vector<Frame> frames(kFramesAtOnce);
  for (std::size_t first = 0; first < listed.size(); first += kFramesAtOnce) {
    const std::size_t n = std::min(kFramesAtOnce, listed.size() - first);
    parallel_for(n, [&](std::size_t k) {
      const std::uint64_t index = listed[first + k].index;
      const double t_s = static_cast<double>(index) / run.options.frames.rate_hz;
      frames[k] = expose_frame(run.world, run.renderer, run.trajectory, run.options, t_s, index);
    });
    for (std::size_t k = 0; k < n; ++k)
      PLED_TRY(run.writer.write_frame(listed[first + k].index, frames[k], run.renderer.width(),
                                      run.renderer.height()));
    run.report(kFramesShare * static_cast<double>(first + n) / static_cast<double>(listed.size()));
  }
  PLED_TRY(run.writer.write_frame_lists(listed));
  return static_cast<std::uint64_t>(listed.size());
}

/// The samples as they arrive: by the IMU's own clock, without those in the gap.
std::vector<ImuSample> as_received(const std::vector<ImuSample>& samples, const FaultOptions& f) {
  std::vector<ImuSample> out;
  for (ImuSample s : samples) {
    const double t_s = s.t.seconds();
    if (t_s >= f.imu_gap_at_s && t_s < f.imu_gap_at_s + f.imu_gap_s) continue;
    s.t.us += std::llround(static_cast<double>(s.t.us) * 1e-6 * f.imu_drift_ppm);
    out.push_back(s);
  }
  return out;
}

/// Renders a few instants at once, takes every pixel through them, writes what fired.
class EventRun {
 public:
  explicit EventRun(const Run& run)
      : run_(run),
        model_(run.event_renderer.width(), run.event_renderer.height(), run.options.events,
               run.options.seed),
        row_events_(static_cast<std::size_t>(run.event_renderer.height())) {}

  Result<void> write(SimulationSummary& summary) {
    render(0.0, views_.back());
    model_.start({0.0, views_.back().radiance});
    summary.event_renders = 1;
    const double end_s = run_.options.duration_s;
    for (double t_s = 0.0; t_s < end_s;) {
      // The plan comes from the last render of the batch before, so it keeps a reserve for
      // what changes in eight steps.
      const double step_s =
          kPlanReserve * plan_step_s(run_.world, run_.event_renderer, run_.trajectory, run_.options,
                                     views_.back(), t_s);
      t_s = advance(t_s, step_s, end_s);
      summary.event_renders += kRendersAtOnce;
      summary.events += events_.size();
      PLED_TRY(run_.writer.write_events(events_));
      run_.report(kFramesShare + (1.0 - kFramesShare) * t_s / end_s);
    }
    return {};
  }

 private:
  void render(double t_s, View& view) const {
    const Pose& T_body_cam = run_.options.camera_of_events().T_body_cam;
    run_.event_renderer.render(run_.trajectory.at(t_s).T_world_body * T_body_cam, t_s, view);
    const auto light = static_cast<float>(brightness(run_.options.faults, t_s));
    if (light == 1.0F) return;
    for (float& radiance : view.radiance) radiance *= light;
  }

  /// One batch, its end not beyond `end_s`. Returns the time of its last render.
  double advance(double t_s, double step_s, double end_s) {
    step_s = std::min(step_s, (end_s - t_s) / static_cast<double>(kRendersAtOnce));
    std::array<Exposure, kRendersAtOnce> exposures;
    for (std::size_t k = 0; k < kRendersAtOnce; ++k)
      exposures[k].t_s = t_s + static_cast<double>(k + 1) * step_s;
    parallel_for(kRendersAtOnce, [&](std::size_t k) { render(exposures[k].t_s, views_[k]); });
    for (std::size_t k = 0; k < kRendersAtOnce; ++k) exposures[k].radiance = views_[k].radiance;
    parallel_for(row_events_.size(), [&](std::size_t y) {
      row_events_[y].clear();
      model_.advance_row(static_cast<int>(y), exposures, row_events_[y]);
    });
    model_.advanced_to(exposures.back().t_s);
    events_.clear();
    for (const std::vector<Event>& row : row_events_)
      events_.insert(events_.end(), row.begin(), row.end());
    sort_as_sent(events_);
    stamp();
    // The last batch may miss the end by rounding; it is the end.
    return exposures.back().t_s > end_s - 1e-9 ? end_s : exposures.back().t_s;
  }

  /// From the simulation's time to the camera's clock; what lies before its zero was not recorded.
  void stamp() {
    const Duration late = Duration::from_s(run_.options.faults.camera_late_s);
    if (late.us == 0) return;
    for (Event& event : events_) event.t = event.t + late;
    std::erase_if(events_, [](const Event& event) { return event.t.us < 0; });
  }

  const Run& run_;
  EventModel model_;
  std::array<View, kRendersAtOnce> views_;
  std::vector<std::vector<Event>> row_events_;
  std::vector<Event> events_;
};

double path_length_m(const Trajectory& trajectory, double duration_s) {
  double sum_m = 0.0;
  Eigen::Vector3d last = trajectory.at(0.0).T_world_body.p;
  const auto count = static_cast<int>(duration_s * kTruthRateHz + 1e-6);
  for (int i = 1; i <= count; ++i) {
    const Eigen::Vector3d p = trajectory.at(i / kTruthRateHz).T_world_body.p;
    sum_m += (p - last).norm();
    last = p;
  }
  return sum_m;
}

Result<SimulationSummary> simulate_checked(const SimulationOptions& options,
                                           const std::filesystem::path& out_dir,
                                           const ProgressCallback& progress) {
  const Result<std::unique_ptr<Trajectory>> made = make_trajectory(options);
  PLED_TRY(made);
  const Trajectory& trajectory = *made.value();
  if (options.duration_s > trajectory.longest_s()) return ErrorCode::kEndOfStream;
  World world = lay_out(options);
  if (const auto contact_s = first_contact_s(world, trajectory, options.duration_s))
    return Error{ErrorCode::kUnsupported, std::llround(*contact_s * 1e3)};
  if (options.bus.comes()) world.boxes.push_back(make_bus(options.bus, trajectory));
  paint_boxes(world, options.seed);
  const Result<Renderer> renderer = Renderer::create(world, options.camera);
  PLED_TRY(renderer);
  RecordingWriter writer{out_dir};
  const Result<Renderer> of_events = Renderer::create(world, options.camera_of_events());
  PLED_TRY(of_events);
  const Run run{options, world, renderer.value(), of_events.value(), trajectory, writer, progress};

  SimulationSummary summary;
  summary.duration_s = options.duration_s;
  summary.path_m = path_length_m(trajectory, options.duration_s);
  PLED_TRY(writer.create(options));
  PLED_TRY(writer.write_calibration(options));
  const SimulatedImu imu = simulate_imu(trajectory, options.duration_s, options.imu, options.seed);
  const std::vector<ImuSample> received = as_received(imu.samples, options.faults);
  summary.imu_samples = received.size();
  PLED_TRY(writer.write_imu(received));
  PLED_TRY(writer.write_truth(trajectory, options.duration_s, kTruthRateHz));
  PLED_TRY(writer.write_states(trajectory, imu));
  const Result<std::uint64_t> frames = write_frames(run);
  PLED_TRY(frames);
  summary.frames = frames.value();
  PLED_TRY(EventRun{run}.write(summary));
  PLED_TRY(writer.finish());
  return summary;
}

}  // namespace

Result<SimulationSummary> simulate(const SimulationOptions& options,
                                   const std::filesystem::path& out_dir,
                                   const ProgressCallback& progress) noexcept {
  if (check(options).key != nullptr) return ErrorCode::kInvalidArgument;
  try {  // the standard library's containers and files may throw; nobody outside has to know
    return simulate_checked(options, out_dir, progress);
  } catch (const std::bad_alloc&) {
    return ErrorCode::kTooLarge;
  } catch (...) {
    return ErrorCode::kIoFailure;
  }
}

}  // namespace pled::sim
