#pragma once

#include <cstdint>

#include "pled_vins/core/config_issue.hpp"
#include "pled_vins/events/config.hpp"
#include "pled_vins/frontend/lines/config.hpp"

namespace pled {

/// Whose pictures lines are looked for in.
enum class LineSource : std::uint8_t { kNone, kEvents, kFrames, kBoth };

[[nodiscard]] constexpr bool from_events(LineSource source) noexcept {
  return source == LineSource::kEvents || source == LineSource::kBoth;
}
[[nodiscard]] constexpr bool from_frames(LineSource source) noexcept {
  return source == LineSource::kFrames || source == LineSource::kBoth;
}
/// What is left of `source` where frames or events are not looked at.
[[nodiscard]] constexpr LineSource narrowed(LineSource source, bool has_frames,
                                            bool has_events) noexcept {
  const bool frames = from_frames(source) && has_frames;
  const bool events = from_events(source) && has_events;
  if (frames && events) return LineSource::kBoth;
  return frames ? LineSource::kFrames : events ? LineSource::kEvents : LineSource::kNone;
}

/// Tuning of the line stage.
struct LineStageConfig {
  /// Paper: events. Frames show more lines, for longer, and twice as exactly
  /// (src/frontend/lines/README.md).
  LineSource source = LineSource::kFrames;
  /// How events are drawn for lines, whatever points are followed in. Paper: the time surface.
  EventPicture event_picture = EventPicture::kBrightness;
  LineConfig tracking;
};

[[nodiscard]] constexpr ConfigIssue check(const LineStageConfig& c) noexcept {
  return check(c.tracking);
}

}  // namespace pled
