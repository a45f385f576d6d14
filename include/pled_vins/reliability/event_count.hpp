#pragma once

#include <cstdint>

namespace pled {

/// The bare event count as a cue, to measure others against: 1 without events, 1/2 at `half_count`
/// (> 0), towards 0 for many. It falls strictly with n, so it ranks pixels as the count does. Ours.
[[nodiscard]] constexpr double event_count_reliability(std::uint32_t n,
                                                       double half_count = 8.0) noexcept {
  return half_count / (half_count + static_cast<double>(n));
}

}  // namespace pled
