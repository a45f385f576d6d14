#pragma once

#include <algorithm>
#include <initializer_list>
#include <string>
#include <vector>

#include "drivers/replay/recording_info.hpp"
#include "unit/drivers/evt3_words.hpp"

/// Reads whole recordings for tests.
namespace pled::support {

/// Everything that a recording gives, frames as copies.
struct Played {
  std::vector<Event> events;
  std::vector<ImuSample> imu;
  std::vector<FrameView> frames;  ///< of which the pixels are in `pixels`
  std::vector<std::vector<std::uint8_t>> pixels;
  std::uint64_t lost_packets = 0;  ///< of events
  std::uint64_t bad_samples = 0;
  std::uint64_t bad_frames = 0;
  DecoderFaults faults;
};

inline void play_events(const replay::Recording& recording, Played& out) {
  replay::Problems problems;
  auto opened = recording.open_events(problems);
  if (!opened.ok()) return;
  auto& source = *opened.value().source;
  EventDecoder& decoder = *opened.value().decoder;
  if (!source.start().ok()) return;
  for (auto chunk = source.acquire({}); chunk.ok(); chunk = source.acquire({})) {
    if (chunk.value().after_gap) decoder.resynchronise();
    const auto events = decode_all(decoder, chunk.value().bytes);
    out.events.insert(out.events.end(), events.begin(), events.end());
    source.release();
  }
  decoder.finish();
  out.lost_packets = source.lost_packets();
  out.faults = decoder.faults();
}

[[nodiscard]] inline Played play(const replay::Recording& recording) {
  Played out;
  replay::Problems problems;
  play_events(recording, out);
  if (auto imu = recording.open_imu(problems); imu.ok()) {
    while (true) {
      const auto sample = imu.value()->read({});
      if (sample.ok()) out.imu.push_back(sample.value());
      if (!sample.ok() && sample.error().code != ErrorCode::kBadNumber) break;
    }
    out.bad_samples = imu.value()->malformed();
  }
  if (auto frames = recording.open_frames(1, problems); frames.ok()) {
    while (true) {
      const auto frame = frames.value()->acquire({});
      if (!frame.ok() && frame.error().code != ErrorCode::kCorrupt) break;
      if (!frame.ok()) continue;
      const auto& image = frame.value().image;
      out.frames.push_back(frame.value());
      std::vector<std::uint8_t>& pixels = out.pixels.emplace_back();
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) pixels.push_back(image.at(y, x));
      frames.value()->release();
    }
    out.bad_frames = frames.value()->faults().unreadable;
  }
  return out;
}

/// True when one problem's words hold all of the parts.
[[nodiscard]] inline bool says(const replay::Problems& problems,
                               std::initializer_list<const char*> parts) {
  return std::any_of(problems.begin(), problems.end(), [&](const replay::Problem& problem) {
    const std::string words = replay::to_string(problem);
    return std::all_of(parts.begin(), parts.end(),
                       [&](const char* part) { return words.find(part) != std::string::npos; });
  });
}
[[nodiscard]] inline bool says(const std::vector<std::string>& words,
                               std::initializer_list<const char*> parts) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return std::all_of(parts.begin(), parts.end(),
                       [&](const char* part) { return word.find(part) != std::string::npos; });
  });
}

}  // namespace pled::support
