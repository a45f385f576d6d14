#include "drivers/replay/recording_info.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <utility>

#include "drivers/replay/survey_tools.hpp"

namespace pled::replay {
namespace {

constexpr ImageSize kAnySensor{2048, 2048};  // the address space of the encodings

void say_faults(std::vector<std::string>& problems, const std::string& file,
                const DecoderFaults& faults) {
  say_count(problems, file, faults.outside_sensor, "events outside the sensor (dropped)");
  say_count(problems, file, faults.time_backwards, "time steps backwards (time held)");
  say_count(problems, file, faults.malformed, "malformed words or lines (skipped)");
  say_count(problems, file, faults.before_sync,
            "event words before the first time or row (dropped)");
  say_count(problems, file, faults.gaps, "jumps of the time");
}

/// Words for a file whose content is not of the format that it was read as; else empty.
[[nodiscard]] std::string mostly_malformed(const Recording& recording,
                                           const RecordedEventSource& source,
                                           const DecoderFaults& faults, std::uint64_t events) {
  const bool text = recording.event_format() == EventFileFormat::kText;
  if (recording.container() != nullptr) return {};  // told by its first bytes
  // Of random words nearly half are malformed, but the others give events; of damaged
  // recordings not one in a hundred is.
  const std::uint64_t all = text ? events + faults.malformed + faults.outside_sensor
                                 : static_cast<std::uint64_t>(source.size()) / 2;
  if (faults.malformed * (text ? 2 : 10) <= all) return {};
  return std::to_string(faults.malformed) + " of " + std::to_string(all) +
         (text ? " lines are not `t x y p`" : " words are none of EVT3's");
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
  RecordedEventSource& source = *opened.value().source;
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
    if (chunk.value().after_gap) decoder.resynchronise();
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
  decoder.finish();
  const double span_s = info.last_s - info.first_s;
  if (span_s > 0) info.rate_hz = static_cast<double>(info.count) / span_s;
  if (info.width == 0) words.push_back(recording.files().events + ": the sensor size is not given");
  say_count(words, recording.files().events, source.lost_packets(),
            "packets of events that cannot be read (skipped)");
  say_faults(words, recording.files().events, decoder.faults());
  if (info.count == 0) words.push_back(recording.files().events + ": not one event can be read");
  if (const std::string garbage = mostly_malformed(recording, source, decoder.faults(), info.count);
      !garbage.empty()) {
    words.push_back(recording.files().events + ": " + garbage);
    if (recording.layout() != Layout::kFile) return info;
    problems.push_back({Severity::kError, recording.files().events, 0,
                        "is not an event file that can be read: " + garbage});
    return ErrorCode::kUnsupported;
  }
  return info;
}

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
  malformed.finish(recording.container() != nullptr ? "unreadable samples" : "unreadable lines");
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

/// Says when a stream begins long after the frames or ends long before them.
void say_missing_ends(std::vector<std::string>& words, const std::string& file, double first_s,
                      double last_s, const FrameInfo& frames) {
  constexpr double kLong_s = 0.5;
  std::array<char, 128> text{};
  const auto say = [&](const char* format, double at_s, double missing_s) {
    if (!(missing_s > kLong_s)) return;
    std::snprintf(text.data(), text.size(), format, at_s, missing_s);
    words.push_back(file + text.data());
  };
  say(": begins at %.6f s, %.3f s after the first frame", first_s, first_s - frames.first_s);
  say(": ends at %.6f s, %.3f s before the last frame", last_s, frames.last_s - last_s);
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
  if (recording.has(Stream::kFrames) && recording.frame_size() == ImageSize{}) {
    info.problems.push_back(recording.files().frames +
                            ": the frames were not read: their size is not given");
  } else if (recording.has(Stream::kFrames)) {
    PLED_TRY(keep(survey_frames(recording, problems, info.problems, progress), info.frames));
  }
  progress.next_stream(0.4);
  if (recording.has(Stream::kEvents)) {
    PLED_TRY(keep(survey_events(recording, problems, info.problems, progress), info.events));
  }
  if (recording.has(Stream::kTruth)) {
    PLED_TRY(keep(survey_truth(recording, problems, info.problems), info.truth));
  }
  if (recording.has(Stream::kMasks)) info.masks = survey_masks(recording, info.problems);
  if (const Container* const container = recording.container()) {
    auto found = container->survey();
    if (!found.ok()) return found.error();
    info.triggers = {true, found.value().triggers};
    for (std::string& word : found.value().words) info.problems.push_back(std::move(word));
  }
  if (info.frames.count > 0 && info.events.count > 0)
    say_missing_ends(info.problems, recording.files().events, info.events.first_s,
                     info.events.last_s, info.frames);
  if (info.frames.count > 0 && info.imu.count > 0)
    say_missing_ends(info.problems, recording.files().imu, info.imu.first_s, info.imu.last_s,
                     info.frames);
  progress.finish();
  return info;
}

}  // namespace pled::replay
