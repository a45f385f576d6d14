#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/core/timestamp.hpp"

namespace pled {

/// Ids of lines begin here: of those seen in frames, and of those seen in events. Image points lie
/// below the first, event points between the two.
inline constexpr FeatureId kFirstImageLineId = 0x4000'0001U;
inline constexpr FeatureId kFirstEventLineId = 0xC000'0001U;

/// One line in one picture. Its ends are where it was seen to end: they slide along it from picture
/// to picture and are no points. Going from the first to the second the bright side is on the left
/// of a screen (y down), so the two do not swap.
struct LineMeasurement {
  FeatureId id = 0;
  std::uint8_t camera = 0;         ///< index into the rig's cameras
  bool inlier = true;              ///< goes on as it has moved so far (LineTracker)
  std::uint32_t track_length = 1;  ///< pictures in which it has been seen, this one included
  double length_px = 0.0;          ///< in pixels without lens distortion
  std::array<std::array<double, 2>, 2> raw_px{};      ///< ends as the sensor gave them
  std::array<std::array<double, 2>, 2> bearing_xy{};  ///< ends undistorted, z = 1, camera frame
};

/// The lines of one picture.
struct LineFrame {
  Timestamp t;                ///< on the estimator clock
  std::int64_t stamp_ns = 0;  ///< as in FrameView
  FixedVector<LineMeasurement, limits::kMaxLines> lines;
  std::uint32_t lost = 0;  ///< tracks that ended in this picture
};
static_assert(std::is_trivially_copyable_v<LineFrame>);

}  // namespace pled
