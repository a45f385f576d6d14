#include "src/apps/opened_recording.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>
#include <variant>
#include <vector>

#include "drivers/replay/stamp_source.hpp"
#include "pled_vins/config/calibration.hpp"
#include "pled_vins/config/schema.hpp"
#include "pled_vins/pipeline/stamp_guard.hpp"
#include "src/apps/problems.hpp"
#include "src/apps/recording_clocks.hpp"
#include "src/apps/recording_sizes.hpp"
#include "src/apps/settings.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

/// Of observations where a recording has no frames to time them by.
constexpr double kObservationRate_hz = 20.0;

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

/// Regular times while inertial data go on; from a clock that was set they begin anew. Wild stamps
/// count for nothing, so there are never more than the samples span.
std::vector<std::int64_t> regular_times_ns(replay::RecordedImuSource& imu) {
  constexpr int kNeeded = 20;
  StampGuard guard(kNeeded);
  std::vector<std::int64_t> stamps_ns;
  std::optional<Timestamp> first;
  const auto add_until = [&](Timestamp last) {
    const auto more =
        replay::StampSource::regular(first->us * 1000, last.us * 1000, kObservationRate_hz);
    stamps_ns.insert(stamps_ns.end(), more.begin(), more.end());
  };
  for (;;) {
    const Result<ImuSample> sample = imu.read(Duration{});
    if (!sample.ok() && sample.error().code == ErrorCode::kBadNumber) continue;
    if (!sample.ok()) break;
    const std::optional<Timestamp> before = guard.last();
    const StampGuard::Verdict verdict = guard.judge(sample.value().t);
    if (verdict == StampGuard::Verdict::kJumped) add_until(*before);
    if (!first || verdict == StampGuard::Verdict::kJumped) first = sample.value().t;
  }
  if (first) add_until(*guard.last());
  return stamps_ns;
}

/// Times of the observations: the frames' stamps, else regular ones while there are inertial data.
std::vector<std::int64_t> observation_times_ns(const replay::Recording& recording,
                                               replay::Problems& problems) {
  std::vector<std::int64_t> stamps_ns = recording.frame_stamps_ns();
  if (!stamps_ns.empty()) return stamps_ns;
  auto imu = recording.open_imu(problems);
  return imu.ok() ? regular_times_ns(*imu.value()) : stamps_ns;
}

std::optional<Streams> open_streams(const replay::Recording& recording, const PlayOptions& options,
                                    const std::vector<std::int64_t>& stamps_ns,
                                    replay::Problems& problems) {
  Streams streams;
  if (options.use_frames) {
    auto frames = recording.open_frames(limits::kFrameSlots, problems);
    if (!frames.ok()) return std::nullopt;
    streams.frame_file = frames.value().get();
    streams.frames = std::move(frames).value();
  } else {
    streams.frames = std::make_unique<replay::StampSource>(stamps_ns);
  }
  auto imu = recording.open_imu(problems);
  if (!imu.ok()) return std::nullopt;
  streams.imu = std::move(imu).value();
  if (options.use_events && recording.has(replay::Stream::kEvents)) {
    auto events = recording.open_events(problems);
    if (!events.ok()) return std::nullopt;
    streams.events = std::move(events).value();
    if (!streams.events->source->start().ok()) return std::nullopt;
  }
  return streams;
}

/// How long the observations go on. Steps that only a wrong stamp or a clock that was set can make
/// do not count.
double length_s(const std::vector<std::int64_t>& stamps_ns) {
  constexpr double kLongestPause_s = 60.0;
  double length_s = 0.0;
  for (std::size_t k = 1; k < stamps_ns.size(); ++k) {
    const double step_s = static_cast<double>(stamps_ns[k] - stamps_ns[k - 1]) * 1e-9;
    if (step_s > 0.0 && step_s < kLongestPause_s) length_s += step_s;
  }
  return length_s;
}

/// Says when nothing of the recording is left behind the start.
bool start_is_inside(double whole_s, const PlayOptions& options) {
  if (options.start_s <= whole_s) return true;
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(),
                "--start %g lies behind the last frame: the recording has %g s of frames",
                options.start_s, whole_s);
  print_error(text.data());
  return false;
}

/// What the estimator sees by must be there.
bool has_what_it_needs(const replay::Recording& recording, const PlayOptions& options,
                       replay::Problems& problems) {
  const bool eyes =
      recording
          .require(options.use_frames ? replay::Stream::kFrames : replay::Stream::kEvents, problems)
          .ok();
  const bool inertial = recording.require(replay::Stream::kImu, problems).ok();
  if (!(eyes && inertial) && problems.empty())
    print_error("the recording lacks frames or inertial data");
  return eyes && inertial;
}

/// Where lines are looked for: what is not looked at shows none.
LineSource line_source(const AppConfig& config, const PlayOptions& options,
                       const Streams& streams) {
  return narrowed(config.lines.source, options.use_frames, streams.events.has_value());
}

/// Says when the settings want lines of what is not looked at alone.
void tell_missing_lines(LineSource wanted, LineSource left) {
  if (wanted == LineSource::kNone || left != LineSource::kNone) return;
  const std::string name(name_of(wanted));
  print_note("lines.source is '" + name + "', and " + name +
             " are not looked at: there will be no lines");
}

}  // namespace

RunSources Streams::sources() const {
  RunSources out{frames.get(), imu.get(), nullptr, nullptr};
  if (events) {
    out.events = events->source.get();
    out.event_decoder = events->decoder.get();
  }
  return out;
}

EstimatorParts OpenedRecording::build(WindowSolver& solver) const {
  EstimatorSettings settings;
  settings.frontend = config.frontend;
  settings.backend = config.backend;
  settings.pipeline.find_time_shift = config.backend.find_time_shift;
  settings.pipeline.use_frames = options.use_frames;
  settings.pipeline.motion_cue = config.motion_cue;
  settings.pipeline.score = options.score.value_or(config.reliability.score);
  settings.pipeline.all_scores = options.all_scores;
  settings.lines = config.lines;
  settings.lines.source = line_source(config, options, streams);
  if (streams.events) {
    EventStageConfig events{config.events, config.frontend, config.reliability, false, {}};
    if (from_events(settings.lines.source)) events.line_picture = config.lines.event_picture;
    events.keep_map = options.all_scores || settings.pipeline.score != TemporalScore::kMotion;
    // Alone, events get the whole pool.
    if (!options.use_frames)
      events.events.max_points = std::max(events.events.max_points, config.frontend.max_points);
    settings.events = events;
  }
  return build_estimator(*sensor, rig, settings, solver);
}

bool OpenedRecording::rewind() {
  replay::Problems problems;
  std::vector<std::int64_t> stamps_ns;  // pictures bring their own
  if (!options.use_frames) stamps_ns = observation_times_ns(recording, problems);
  std::optional<Streams> again = open_streams(recording, options, stamps_ns, problems);
  // Whatever does not stand in the way was told when the recording was opened.
  if (!again) {
    print_problems(problems);
    return false;
  }
  streams = std::move(*again);
  return true;
}

RunSpan OpenedRecording::span() const {
  RunSpan span{Duration::from_s(options.start_s), std::nullopt};
  if (options.duration_s) span.length = Duration::from_s(*options.duration_s);
  return span;
}

double OpenedRecording::played_s() const {
  const double rest_s = std::max(0.0, whole_s - options.start_s);
  return options.duration_s ? std::min(rest_s, *options.duration_s) : rest_s;
}

std::optional<OpenedRecording> open_recording(const PlayOptions& options) {
  std::optional<AppConfig> config = settings_for(options.recording, options.config);
  if (!config) return std::nullopt;
  replay::Problems problems;
  Result<replay::Recording> opened = replay::Recording::open(options.recording, problems);
  const bool complete = opened.ok() && has_what_it_needs(opened.value(), options, problems);
  if (print_problems(problems) || !complete) return std::nullopt;
  replay::Recording& recording = opened.value();
  const std::optional<RigCalibration> rig = calibration(options.recording, *config);
  if (!rig) return std::nullopt;
  std::string refusal = apply_calibrated_sizes(recording, *rig);
  const limits::SensorClass* sensor = refusal.empty() ? sensor_class(recording, refusal) : nullptr;
  // Without frames the times of observations are the IMU's own.
  if (refusal.empty() && (options.use_frames || !recording.frame_stamps_ns().empty()))
    refusal = clock_problem(recording, rig->cameras[rig->frame_camera].time_shift_s);
  if (!refusal.empty()) {
    print_error(refusal);
    return std::nullopt;
  }
  problems.clear();
  const std::vector<std::int64_t> stamps_ns = observation_times_ns(recording, problems);
  const double whole_s = length_s(stamps_ns);
  if (!start_is_inside(whole_s, options)) return std::nullopt;
  std::optional<Streams> streams = open_streams(recording, options, stamps_ns, problems);
  if (print_problems(problems) || !streams) return std::nullopt;
  tell_missing_lines(config->lines.source, line_source(*config, options, *streams));
  return OpenedRecording{options, *config, std::move(recording),  *rig,
                         sensor,  whole_s, frame_span(stamps_ns), std::move(*streams)};
}

}  // namespace pled::apps
