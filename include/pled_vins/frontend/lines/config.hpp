#pragma once

#include "pled_vins/core/config_issue.hpp"
#include "pled_vins/core/limits.hpp"

namespace pled {

/// Tuning of lines: which are taken, and how far they may go from picture to picture. Pixels are
/// those of a picture 240 wide; in wider ones `search_px` grows with the width, up to 3x.
struct LineConfig {
  int max_lines = 60;               ///< followed at once, 4 ... limits::kMaxLines
  double min_length_share = 0.125;  ///< of the picture's shorter side, 0.03 ... 0.5; 10 px or more
  double max_bow_px = 1.0;          ///< of an edge from its chord, 0.2 ... 5
  double search_px = 8.0;  ///< a line's way across, its turn with the camera taken out, 1 ... 30
};

[[nodiscard]] constexpr ConfigIssue check(const LineConfig& c) noexcept {
  if (!(c.max_lines >= 4 && c.max_lines <= static_cast<int>(limits::kMaxLines)))
    return {"lines.max_lines", "must be in [4, 64]"};
  if (!(c.min_length_share >= 0.03 && c.min_length_share <= 0.5))
    return {"lines.min_length_share", "must be in [0.03, 0.5]"};
  if (!(c.max_bow_px >= 0.2 && c.max_bow_px <= 5))
    return {"lines.max_bow_px", "must be in [0.2, 5]"};
  if (!(c.search_px >= 1 && c.search_px <= 30)) return {"lines.search_px", "must be in [1, 30]"};
  return {};
}
static_assert(check(LineConfig{}).key == nullptr, "defaults must be valid");

}  // namespace pled
