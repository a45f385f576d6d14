#pragma once

#include <cstdint>

#include "pled_vins/core/config_issue.hpp"

namespace pled {

/// The picture that event points are followed in.
enum class EventPicture : std::uint8_t {
  kBrightness,   ///< what events add up to; ours, see BrightnessSurface
  kTimeSurface,  ///< the paper's: when edges passed, compensated for turning
};

/// Tuning of the event front end. Capacities are in core/limits.hpp.
struct EventConfig {
  /// kappa: an event of the same polarity as the one before it on its pixel is redundant within
  /// this. 0 to 1000 ms. ESVIO and PL-EVIO take 10.
  double redundant_ms = 10.0;
  /// A pixel that fires faster than this over more than hot_burst events is hot, Hz. Ours.
  double hot_rate_hz = 1000.0;
  int hot_burst = 16;  ///< events, 2 to 1000; hot_burst / hot_rate_hz is at most 30 ms
  /// More events than this are not looked at, millions a second. Bounds time in a burst. Ours.
  double max_rate_mevps = 20.0;
  EventPicture picture = EventPicture::kBrightness;
  /// tau of the brightness picture, 10 to 2000 ms. Ours.
  double brightness_decay_ms = 150.0;
  /// eta of the time surface, 1 to 500 ms. Paper, eq. (1).
  double surface_decay_ms = 20.0;
  int max_points = 30;  ///< event points followed at once; 0: none
  /// Between event corners, 3 to 100, at 240 px width; scaled by width / 240 up to 3x
  double corner_min_distance_px = 10.0;
  /// An older event is no candidate. Ours. At high rates corner_max_candidates ends the scan first.
  double corner_max_age_ms = 30.0;
  int corner_max_candidates = 4096;  ///< events looked at in one scan, bounds its time
};

/// The first broken rule in the words of the file, or key == nullptr.
[[nodiscard]] constexpr ConfigIssue check(const EventConfig& c) noexcept {
  if (!(c.redundant_ms >= 0 && c.redundant_ms <= 1000))
    return {"events.redundant_ms", "must be in [0, 1000]"};
  if (!(c.hot_rate_hz >= 100 && c.hot_rate_hz <= 1e5))
    return {"events.hot_rate_hz", "must be in [100, 100000]"};
  if (!(c.hot_burst >= 2 && c.hot_burst <= 1000))
    return {"events.hot_burst", "must be in [2, 1000]"};
  if (!(c.hot_burst <= 0.03 * c.hot_rate_hz))
    return {"events.hot_burst", "must take at most 30 ms at events.hot_rate_hz"};
  if (!(c.max_rate_mevps >= 0.1 && c.max_rate_mevps <= 1000))
    return {"events.max_rate_mevps", "must be in [0.1, 1000]"};
  if (!(c.brightness_decay_ms >= 10 && c.brightness_decay_ms <= 2000))
    return {"events.brightness_decay_ms", "must be in [10, 2000]"};
  if (!(c.surface_decay_ms >= 1 && c.surface_decay_ms <= 500))
    return {"events.surface_decay_ms", "must be in [1, 500]"};
  if (!(c.max_points == 0 || (c.max_points >= 20 && c.max_points <= 150)))
    return {"events.max_points", "must be 0 or in [20, 150]"};
  if (!(c.corner_min_distance_px >= 3 && c.corner_min_distance_px <= 100))
    return {"events.corner_min_distance_px", "must be in [3, 100]"};
  if (!(c.corner_max_age_ms >= 0.01 && c.corner_max_age_ms <= 1000))
    return {"events.corner_max_age_ms", "must be in [0.01, 1000]"};
  if (!(c.corner_max_candidates >= 1 && c.corner_max_candidates <= 8192))
    return {"events.corner_max_candidates", "must be in [1, 8192]"};
  return {};
}
static_assert(check(EventConfig{}).key == nullptr, "defaults must be valid");

}  // namespace pled
