#include "drivers/replay/recording_info.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <utility>

namespace pled::replay {
namespace {

constexpr ImageSize kAnySensor{2048, 2048};  // the address space of the encodings

/// Says the first few problems of a kind and counts the others.
class ProblemList {
 public:
  explicit ProblemList(std::vector<std::string>& out) : out_(out) {}
  void add(std::string_view text) {
    if (++count_ <= kMaxProblemsOfAKind) out_.emplace_back(text);
  }
  void finish(const std::string& kind) {
    if (count_ > kMaxProblemsOfAKind) {
      out_.push_back("... and " + std::to_string(count_ - kMaxProblemsOfAKind) + " more " + kind);
    }
  }

 private:
  std::vector<std::string>& out_;
  std::uint64_t count_ = 0;
};

/// Rising progress over the streams, each with a share of the whole.
class Progress {
 public:
  explicit Progress(const std::function<void(double)>& report) : report_(report) {}
  void next_stream(double share) {
    begin_ += share_;
    share_ = share;
    at(0.0);
  }
  void at(double part) {
    const double value = std::min(begin_ + share_ * std::clamp(part, 0.0, 1.0), 1.0);
    if (report_ && value >= last_ + kStep) report_(last_ = value);
  }
  void finish() {
    if (report_) report_(1.0);
  }

 private:
  static constexpr double kStep = 1e-3;
  const std::function<void(double)>& report_;
  double begin_ = 0.0;
  double share_ = 0.0;
  double last_ = -kStep;
};

void say_count(std::vector<std::string>& problems, const std::string& file, std::uint64_t count,
               const char* what) {
  if (count > 0) problems.push_back(file + ": " + std::to_string(count) + " " + what);
}

void say_faults(std::vector<std::string>& problems, const std::string& file,
                const DecoderFaults& faults) {
  say_count(problems, file, faults.outside_sensor, "events outside the sensor (dropped)");
  say_count(problems, file, faults.time_backwards, "time steps backwards (time held)");
  say_count(problems, file, faults.malformed, "malformed words or lines (skipped)");
  say_count(problems, file, faults.before_sync,
            "event words before the first time or row (dropped)");
  say_count(problems, file, faults.gaps, "jumps of the time");
}

[[nodiscard]] Result<EventInfo> survey_events(const Recording& recording, Problems& problems,
                                              std::vector<std::string>& words, Progress& progress) {
  Recording sized = recording;
  const ImageSize told = recording.event_size();
  // Also when the calibration tells of a sensor that no encoding can address.
  if (told == ImageSize{} || told.width_px > kAnySensor.width_px ||
      told.height_px > kAnySensor.height_px)
    sized.set_event_size(kAnySensor);
  auto opened = sized.open_events(problems);
  if (!opened.ok()) return opened.error();
  RawFileSource& source = *opened.value().source;
  EventDecoder& decoder = *opened.value().decoder;
  PLED_TRY(source.start());

  EventInfo info;
  info.present = true;
  info.width = told.width_px;
  info.height = told.height_px;
  std::vector<Event> events(limits::kChunkBytes);
  while (true) {
    const auto chunk = source.acquire(Duration{});
    if (!chunk.ok()) {
      if (chunk.error().code == ErrorCode::kEndOfStream) break;
      words.push_back(recording.files().events + ": reading failed; the rest is unknown");
      break;
    }
    std::span<const std::byte> bytes = chunk.value().bytes;
    while (!bytes.empty()) {
      const DecodeStep step = decoder.decode(bytes, events);
      bytes = bytes.subspan(step.bytes_consumed);
      if (step.events == 0) continue;
      if (info.count == 0) info.first_s = events[0].t.seconds();
      info.last_s = events[step.events - 1].t.seconds();
      info.count += step.events;
    }
    source.release();
    progress.at(static_cast<double>(source.position()) / static_cast<double>(source.size()));
  }
  const double span_s = info.last_s - info.first_s;
  if (span_s > 0) info.rate_hz = static_cast<double>(info.count) / span_s;
  if (info.width == 0) words.push_back(recording.files().events + ": the sensor size is not given");
  say_faults(words, recording.files().events, decoder.faults());
  return info;
}

/// Median of intervals in whole microseconds, exact up to kMaxUs, in fixed memory.
class IntervalMedian {
 public:
  void add(std::int64_t interval_us) {
    ++counts_[static_cast<std::size_t>(std::clamp<std::int64_t>(interval_us, 0, kMaxUs))];
    ++total_;
  }
  /// Zero without intervals.
  [[nodiscard]] std::int64_t median_us() const {
    std::uint64_t below = 0;
    for (std::size_t us = 0; us < counts_.size(); ++us) {
      below += counts_[us];
      if (2 * below > total_) return static_cast<std::int64_t>(us);
    }
    return 0;
  }

 private:
  static constexpr std::int64_t kMaxUs = 1'000'000;
  std::vector<std::uint32_t> counts_ = std::vector<std::uint32_t>(kMaxUs + 1);
  std::uint64_t total_ = 0;
};

/// Calls visit(sample, advance) for each readable sample; `advance` is the time
/// since the latest stamp so far, absent for the first.
template <typename Visit>
[[nodiscard]] Result<void> visit_imu(const Recording& recording, Problems& problems,
                                     ProblemList& malformed, Progress& progress, Visit visit) {
  auto source = recording.open_imu(problems);
  if (!source.ok()) return source.error();
  std::optional<Timestamp> latest;
  while (true) {
    const auto sample = source.value()->read(Duration{});
    if (!sample.ok() && sample.error().code == ErrorCode::kBadNumber) {
      malformed.add(source.value()->last_message());
      continue;
    }
    if (!sample.ok() && sample.error().code == ErrorCode::kEndOfStream) return {};
    if (!sample.ok()) return sample.error();
    const Timestamp t = sample.value().t;
    visit(t, latest ? std::optional{t - *latest} : std::nullopt);
    latest = latest ? std::max(*latest, t) : t;
    progress.at(source.value()->progress());
  }
}

[[nodiscard]] Result<ImuInfo> survey_imu(const Recording& recording, Problems& problems,
                                         std::vector<std::string>& words, Progress& progress) {
  ImuInfo info;
  info.present = true;
  IntervalMedian intervals;
  ProblemList malformed(words);
  progress.next_stream(0.1);
  const auto first_pass = visit_imu(recording, problems, malformed, progress,
                                    [&](Timestamp t, std::optional<Duration> advance) {
                                      if (info.count++ == 0)
                                        info.first_s = info.last_s = t.seconds();
                                      info.last_s = std::max(info.last_s, t.seconds());
                                      if (!advance) return;
                                      if (advance->us == 0) ++info.duplicates;
                                      if (advance->us < 0) ++info.backwards;
                                      if (advance->us > 0) intervals.add(advance->us);
                                    });
  malformed.finish("unreadable lines");
  PLED_TRY(first_pass);
  const std::int64_t median_us = intervals.median_us();
  if (median_us > 0) info.rate_hz = 1e6 / static_cast<double>(median_us);

  constexpr std::int64_t kShortestGapUs = 25'000;
  const std::int64_t limit_us = std::max(4 * median_us, kShortestGapUs);
  ProblemList gaps(words);
  std::vector<std::string> said_already;
  ProblemList ignored(said_already);
  progress.next_stream(0.1);
  const auto second_pass = visit_imu(
      recording, problems, ignored, progress, [&](Timestamp t, std::optional<Duration> advance) {
        if (!advance || advance->us <= limit_us) return;
        ++info.gaps;
        info.longest_gap_s = std::max(info.longest_gap_s, advance->seconds());
        std::array<char, 96> text{};
        std::snprintf(text.data(), text.size(), ": no sample for %.6f s before t = %.6f s",
                      advance->seconds(), t.seconds());
        gaps.add(recording.files().imu + text.data());
      });
  gaps.finish("gaps");
  PLED_TRY(second_pass);
  say_count(words, recording.files().imu, info.duplicates, "repeated stamps");
  say_count(words, recording.files().imu, info.backwards, "stamps that go back");
  return info;
}

[[nodiscard]] Result<FrameInfo> survey_frames(const Recording& recording, Problems& problems,
                                              std::vector<std::string>& words, Progress& progress) {
  auto opened = recording.open_frames(1, problems);
  if (!opened.ok()) return opened.error();
  FrameFileSource& source = *opened.value();
  FrameInfo info;
  info.present = true;
  info.width = recording.frame_size().width_px;
  info.height = recording.frame_size().height_px;
  ProblemList unreadable(words);
  while (true) {
    const auto frame = source.acquire(Duration{});
    progress.at(source.progress());
    if (frame.ok()) {
      const double t_s = frame.value().t.seconds();
      if (info.count++ == 0) info.first_s = t_s;
      info.last_s = t_s;
      source.release();
      continue;
    }
    const ErrorCode code = frame.error().code;
    if (code == ErrorCode::kEndOfStream) break;
    unreadable.add(source.last_message());
    if (code != ErrorCode::kTruncated && code != ErrorCode::kCorrupt) break;
  }
  unreadable.finish("unreadable frames");
  say_count(words, recording.files().frames, source.faults().out_of_order,
            "frames whose stamp is not later than the one before (skipped)");
  const double span_s = info.last_s - info.first_s;
  if (span_s > 0) info.rate_hz = static_cast<double>(info.count - 1) / span_s;
  return info;
}

[[nodiscard]] Result<TruthInfo> survey_truth(const Recording& recording, Problems& problems,
                                             std::vector<std::string>& words) {
  auto opened = recording.open_truth(problems);
  if (!opened.ok()) return opened.error();
  TruthInfo info;
  info.present = true;
  ProblemList malformed(words);
  while (true) {
    const auto state = opened.value().next();
    if (state.ok()) {
      if (info.count++ == 0) info.first_s = state.value().t.seconds();
      info.last_s = state.value().t.seconds();
    } else if (state.error().code == ErrorCode::kBadNumber) {
      malformed.add(opened.value().last_message());
    } else {
      break;
    }
  }
  malformed.finish("unreadable lines");
  return info;
}

}  // namespace

Result<RecordingInfo> survey(const Recording& recording, Problems& problems,
                             const std::function<void(double)>& report) {
  RecordingInfo info;
  Progress progress(report);
  const auto keep = [](auto result, auto& out) -> Result<void> {
    if (!result.ok()) return result.error();
    out = std::move(result).value();
    return {};
  };
  if (recording.has(Stream::kImu)) {
    PLED_TRY(keep(survey_imu(recording, problems, info.problems, progress), info.imu));
  }
  progress.next_stream(0.4);
  if (recording.has(Stream::kFrames)) {
    PLED_TRY(keep(survey_frames(recording, problems, info.problems, progress), info.frames));
  }
  progress.next_stream(0.4);
  if (recording.has(Stream::kEvents)) {
    PLED_TRY(keep(survey_events(recording, problems, info.problems, progress), info.events));
  }
  if (recording.has(Stream::kTruth)) {
    PLED_TRY(keep(survey_truth(recording, problems, info.problems), info.truth));
  }
  info.masks = recording.has(Stream::kMasks);
  progress.finish();
  return info;
}

}  // namespace pled::replay
