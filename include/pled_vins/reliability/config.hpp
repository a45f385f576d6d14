#pragma once

#include <cstdint>

#include "pled_vins/core/config_issue.hpp"
#include "pled_vins/core/limits.hpp"

namespace pled {

/// What tells moving points from those at rest before the bundle adjustment.
enum class TemporalScore : std::uint8_t {
  kMotion,  ///< tracks against the camera's motion; ours
  kPaper,   ///< entropy-recency, to the letter
  kCount,   ///< bare event count, for comparison
};

/// Tuning of the entropy-recency map. Array sizes (B, margin) are in core/limits.hpp.
struct ReliabilityConfig {
  /// Which temporal score is given out. Default: what tells moving points best, see MotionCue.
  TemporalScore score = TemporalScore::kMotion;
  /// Length of a time bin, 256 ... 32768. Ours: 8 x 4.096 ms; the paper gives no window.
  int bin_us = 4096;
  double recency_alpha = 2.0;  ///< alpha of eq. (4), 0.1 ... 10. Paper, section IV-A
  /// How far the picture may turn before the map moves on to a new orientation, 1 ... 16
  double anchor_shift_px = 6.0;
  double anchor_age_ms = 500.0;  ///< and after how long at the latest, 50 ... 900
};

[[nodiscard]] constexpr ConfigIssue check(const ReliabilityConfig& c) noexcept {
  if (!(c.bin_us >= 256 && c.bin_us <= 32768))
    return {"reliability.bin_us", "must be in [256, 32768]"};
  if (!(c.recency_alpha >= 0.1 && c.recency_alpha <= 10))
    return {"reliability.recency_alpha", "must be in [0.1, 10]"};
  if (!(c.anchor_shift_px >= 1 && c.anchor_shift_px <= 16))
    return {"reliability.anchor_shift_px", "must be in [1, 16]"};
  if (!(c.anchor_age_ms >= 50 && c.anchor_age_ms <= 900))
    return {"reliability.anchor_age_ms", "must be in [50, 900]"};
  // Both anchors must lie within the second over which the camera's turning is kept.
  const double oldest_anchor_ms =
      c.anchor_age_ms + 1e-3 * c.bin_us * static_cast<double>(limits::kTimeBins + 1);
  if (!(oldest_anchor_ms < 1000.0))
    return {"reliability.anchor_age_ms",
            "must leave room for nine bins within a second: make it or reliability.bin_us smaller"};
  return {};
}
static_assert(check(ReliabilityConfig{}).key == nullptr, "defaults must be valid");

}  // namespace pled
