#pragma once

#include "pled_vins/core/config_issue.hpp"

namespace pled {

/// Tuning of the motion cue. Chosen on simulated sequences (seeds 1 to 8 of the development set).
struct MotionCueConfig {
  /// Residual at which a point is as likely to move as to rest, 0.05 ... 10
  double even_px = 0.6;
  /// The same of an event point, whose track is less exact, 0.05 ... 10
  double event_even_px = 1.8;
  /// How much less an event point's track counts, 0 ... 1
  double event_weight = 0.3;
  /// How fast belief changes with the logarithm of the residual, 0.2 ... 10
  double steepness = 3.5;
  /// Neighbours at this angle (on the plane z = 1) speak with weight 0.6, 0.005 ... 0.5
  double pool_radius = 0.08;
  /// How much more a point's own track counts than one right beside it, 1 ... 100
  double own_weight = 2.0;
};

[[nodiscard]] constexpr ConfigIssue check(const MotionCueConfig& c) noexcept {
  if (!(c.even_px >= 0.05 && c.even_px <= 10))
    return {"motion_cue.even_px", "must be in [0.05, 10]"};
  if (!(c.event_even_px >= 0.05 && c.event_even_px <= 10))
    return {"motion_cue.event_even_px", "must be in [0.05, 10]"};
  if (!(c.event_weight >= 0 && c.event_weight <= 1))
    return {"motion_cue.event_weight", "must be in [0, 1]"};
  if (!(c.steepness >= 0.2 && c.steepness <= 10))
    return {"motion_cue.steepness", "must be in [0.2, 10]"};
  if (!(c.pool_radius >= 0.005 && c.pool_radius <= 0.5))
    return {"motion_cue.pool_radius", "must be in [0.005, 0.5]"};
  if (!(c.own_weight >= 1 && c.own_weight <= 100))
    return {"motion_cue.own_weight", "must be in [1, 100]"};
  return {};
}
static_assert(check(MotionCueConfig{}).key == nullptr, "defaults must be valid");

}  // namespace pled
