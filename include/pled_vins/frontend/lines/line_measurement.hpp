#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/core/timestamp.hpp"

namespace pled {

/// The lines of one picture.
struct LineFrame {
  Timestamp t;                ///< on the estimator clock
  std::int64_t stamp_ns = 0;  ///< as in FrameView
  FixedVector<LineMeasurement, limits::kMaxLines> lines;
  std::uint32_t lost = 0;  ///< tracks that ended in this picture
};
static_assert(std::is_trivially_copyable_v<LineFrame>);

}  // namespace pled
