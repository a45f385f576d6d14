#pragma once

#include "pled_vins/core/config_issue.hpp"
#include "pled_vins/core/limits.hpp"

namespace pled {

/// Tuning of the frame front end: corners, tracking, motion check.
struct FrontendConfig {
  int max_points = 120;  ///< tracked at once, 20 ... limits::kMaxPoints
  double min_distance_px =
      10.0;  ///< between two points, 3 ... 100, at 240 px width; scaled by width / 240 up to 3x
  double corner_quality = 0.01;  ///< smallest Shi-Tomasi score as a share of the best, 1e-4 ... 0.5
  int pyramid_levels = 4;        ///< 1 ... limits::kMaxPyramidLevels
  int patch_radius_px = 7;       ///< KLT patch is (2r+1)^2, 3 ... 10
  int max_iterations = 20;       ///< KLT steps per level, 3 ... 50
  double forward_backward_px = 0.7;  ///< largest return distance, 0.1 ... 5
  double ransac_px = 1.5;            ///< epipolar gate of the two-point test, 0.2 ... 10
};

[[nodiscard]] constexpr ConfigIssue check(const FrontendConfig& c) noexcept {
  if (!(c.max_points >= 20 && c.max_points <= static_cast<int>(limits::kMaxPoints)))
    return {"frontend.max_points", "must be in [20, 150]"};
  if (!(c.min_distance_px >= 3 && c.min_distance_px <= 100))
    return {"frontend.min_distance_px", "must be in [3, 100]"};
  if (!(c.corner_quality >= 1e-4 && c.corner_quality <= 0.5))
    return {"frontend.corner_quality", "must be in [0.0001, 0.5]"};
  if (!(c.pyramid_levels >= 1 && c.pyramid_levels <= limits::kMaxPyramidLevels))
    return {"frontend.pyramid_levels", "must be in [1, 4]"};
  if (!(c.patch_radius_px >= 3 && c.patch_radius_px <= 10))
    return {"frontend.patch_radius_px", "must be in [3, 10]"};
  if (!(c.max_iterations >= 3 && c.max_iterations <= 50))
    return {"frontend.max_iterations", "must be in [3, 50]"};
  if (!(c.forward_backward_px >= 0.1 && c.forward_backward_px <= 5))
    return {"frontend.forward_backward_px", "must be in [0.1, 5]"};
  if (!(c.ransac_px >= 0.2 && c.ransac_px <= 10))
    return {"frontend.ransac_px", "must be in [0.2, 10]"};
  return {};
}
static_assert(check(FrontendConfig{}).key == nullptr, "defaults must be valid");

}  // namespace pled
