#include "src/apps/replay_session.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <variant>
#include <vector>

#include "drivers/replay/recording.hpp"
#include "pled_vins/backend/ceres_solver.hpp"
#include "pled_vins/backend/window_solver.hpp"
#include "pled_vins/config/app_config.hpp"
#include "pled_vins/config/calibration.hpp"
#include "pled_vins/report/report.hpp"
#include "src/apps/estimator_storage.hpp"
#include "src/apps/output_file.hpp"
#include "src/apps/output_report.hpp"
#include "src/apps/problems.hpp"
#include "src/apps/recording_clocks.hpp"
#include "src/apps/recording_sizes.hpp"
#include "src/apps/replay_output.hpp"
#include "src/apps/replay_summary.hpp"
#include "src/apps/settings.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

std::optional<RigCalibration> calibration(const std::string& recording, const AppConfig& config) {
  auto loaded = load_calibration(recording, config);
  if (const auto* error = std::get_if<ConfigError>(&loaded)) {
    print_error(error->message());
    return std::nullopt;
  }
  const auto& calibration = std::get<LoadedCalibration>(loaded);
  for (const std::string& note : calibration.notes) print_note(note);
  return calibration.rig;
}

/// The opened streams of a recording.
struct Streams {
  std::unique_ptr<replay::RecordedFrameSource> frames;
  std::unique_ptr<replay::RecordedImuSource> imu;
  std::optional<replay::EventReplay> events;

  [[nodiscard]] RunSources sources() const {
    RunSources out{frames.get(), imu.get(), nullptr, nullptr};
    if (events) {
      out.events = events->source.get();
      out.event_decoder = events->decoder.get();
    }
    return out;
  }
};

std::optional<Streams> open_streams(const replay::Recording& recording,
                                    replay::Problems& problems) {
  Streams streams;
  auto frames = recording.open_frames(limits::kFrameSlots, problems);
  auto imu = recording.open_imu(problems);
  if (!frames.ok() || !imu.ok()) return std::nullopt;
  streams.frames = std::move(frames).value();
  streams.imu = std::move(imu).value();
  if (recording.has(replay::Stream::kEvents)) {
    auto events = recording.open_events(problems);
    if (!events.ok()) return std::nullopt;
    streams.events = std::move(events).value();
    if (!streams.events->source->start().ok()) return std::nullopt;
  }
  return streams;
}

/// How long the frames go on, as listed. Steps that only a wrong stamp or a clock that was set can
/// make do not count.
double recording_length_s(const replay::Recording& recording) {
  constexpr double kLongestPause_s = 60.0;
  const std::vector<std::int64_t> stamps_ns = recording.frame_stamps_ns();
  double length_s = 0.0;
  for (std::size_t k = 1; k < stamps_ns.size(); ++k) {
    const double step_s = static_cast<double>(stamps_ns[k] - stamps_ns[k - 1]) * 1e-9;
    if (step_s > 0.0 && step_s < kLongestPause_s) length_s += step_s;
  }
  return length_s;
}

/// Says when nothing of the recording is left behind the start.
bool start_is_inside(double whole_s, const ReplayOptions& options) {
  if (options.start_s <= whole_s) return true;
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(),
                "--start %g lies behind the last frame: the recording has %g s of frames",
                options.start_s, whole_s);
  print_error(text.data());
  return false;
}

/// What the counts of report.json cannot say: where to look.
void tell_last_faults(const Streams& streams) {
  for (const std::string_view words : {streams.frames->last_message(), streams.imu->last_message()})
    if (!words.empty()) print_note("last fault: " + std::string(words));
}

/// Makes the output folder ready and leaves in it what the run is done with. The page
/// of an earlier run goes too: it would speak of results that are no longer there.
bool prepare_results(const ReplayOptions& options, const AppConfig& config) {
  std::string refusal = prepare_output_folder(
      options.out,
      {TrajectoryWriter::kFileName, FeaturesWriter::kFileName, ReplayReport::kFileName,
       ReplayReport::kConfigFileName, report::kReportFileName},
      options.force);
  if (refusal.empty())
    refusal = write_whole(std::filesystem::path(options.out) / ReplayReport::kConfigFileName,
                          to_documented_yaml(config));
  if (!refusal.empty()) print_error(refusal);
  return refusal.empty();
}

double played_length_s(double whole_s, const ReplayOptions& options) {
  const double rest_s = std::max(0.0, whole_s - options.start_s);
  return options.duration_s ? std::min(rest_s, *options.duration_s) : rest_s;
}

}  // namespace

bool run_replay(const ReplayOptions& options) {
  const std::optional<AppConfig> config = settings_for(options.recording, options.config);
  if (!config) return false;
  replay::Problems problems;
  Result<replay::Recording> opened = replay::Recording::open(options.recording, problems);
  if (opened.ok()) {
    const bool frames = opened.value().require(replay::Stream::kFrames, problems).ok();
    const bool inertial = opened.value().require(replay::Stream::kImu, problems).ok();
    if (!(frames && inertial) && problems.empty())
      print_error("the recording lacks frames or inertial data");
  }
  if (print_problems(problems) || !opened.ok()) return false;
  replay::Recording& recording = opened.value();
  const std::optional<RigCalibration> rig = calibration(options.recording, *config);
  if (!rig) return false;
  std::string refusal = apply_calibrated_sizes(recording, *rig);
  const limits::SensorClass* sensor = refusal.empty() ? sensor_class(recording, refusal) : nullptr;
  if (refusal.empty())
    refusal = clock_problem(recording, rig->cameras[rig->frame_camera].time_shift_s);
  if (!refusal.empty()) {
    print_error(refusal);
    return false;
  }
  const double whole_s = recording_length_s(recording);
  if (!start_is_inside(whole_s, options)) return false;
  problems.clear();
  const std::optional<Streams> streams = open_streams(recording, problems);
  if (print_problems(problems) || !streams) return false;
  // Last: with --force it removes the results of an earlier run.
  if (!prepare_results(options, *config)) return false;

  const std::unique_ptr<WindowSolver> solver = make_ceres_solver();
  const EstimatorParts parts =
      build_estimator(*sensor, *rig, config->frontend, config->backend, *solver);
  Progress progress = Progress::on_stderr(played_length_s(whole_s, options));
  ReplayMeters meters;
  ReplayOutput output(progress, meters);
  if (const std::string problem = output.open(options.out); !problem.empty()) {
    print_error(problem);
    return false;
  }
  RunSpan span{Duration::from_s(options.start_s), std::nullopt};
  if (options.duration_s) span.length = Duration::from_s(*options.duration_s);
  const RunEnd end = parts.runner->run(streams->sources(), span, output);
  meters.stop();
  progress.finish();
  tell_last_faults(*streams);
  if (streams->events && parts.health->events.in == 0)
    print_note(recording.files().events + " gave not one event in the time that was played");
  return finish_replay({options, recording, *sensor, parts, end, meters, streams->frames->faults()},
                       output);
}

}  // namespace pled::apps
