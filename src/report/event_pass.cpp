#include "src/report/event_pass.hpp"

#include <string_view>
#include <vector>

#include "pled_vins/core/limits.hpp"

namespace pled::report {

std::string visit_events(const replay::Recording& recording,
                         const std::function<bool(std::span<const Event>)>& visit) {
  replay::Problems problems;
  auto opened = recording.open_events(problems);
  if (!opened.ok())
    return problems.empty() ? "the events cannot be opened" : replay::to_string(problems.back());
  replay::EventReplay& replay = opened.value();
  if (!replay.source->start().ok()) return "the events cannot be read";
  std::vector<Event> batch(limits::kMaxEventsPerChunk);
  while (true) {
    const auto chunk = replay.source->acquire(Duration{});
    if (!chunk.ok()) {
      if (chunk.error().code == ErrorCode::kEndOfStream) return {};
      return "reading the events failed: " + std::string(to_string(chunk.error().code));
    }
    std::span<const std::byte> bytes = chunk.value().bytes;
    while (!bytes.empty()) {
      const DecodeStep step = replay.decoder->decode(bytes, batch);
      bytes = bytes.subspan(step.bytes_consumed);
      if (!visit({batch.data(), step.events})) return {};
    }
    replay.source->release();
  }
}

}  // namespace pled::report
