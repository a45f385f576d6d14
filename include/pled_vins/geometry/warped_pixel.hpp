#pragma once

#include <cstdint>
#include <limits>

namespace pled {

/// An integer pixel of the rectified grid, to which events are carried.
struct WarpedPixel {
  std::int16_t x_px = 0;
  std::int16_t y_px = 0;

  friend constexpr bool operator==(const WarpedPixel&, const WarpedPixel&) = default;
};

/// What an event that misses the grid becomes.
inline constexpr WarpedPixel kOutsideGrid{std::numeric_limits<std::int16_t>::min(),
                                          std::numeric_limits<std::int16_t>::min()};

}  // namespace pled
