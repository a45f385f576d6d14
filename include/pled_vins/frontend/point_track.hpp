#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/frontend/reference_patches.hpp"

namespace pled {

/// Frames over which the motion check may reach back, the newest included.
inline constexpr std::size_t kTrackHistory = 8;

/// The sight from which on an event point is worth using. Where a corner is new, events have drawn
/// only the side it moves to; until the rest is drawn, matches stay behind the motion by 0.3 to 0.8
/// px (simulated, against the truth), later by less than 0.1 px.
inline constexpr std::uint32_t kSettledSights = 4;

/// One point that is being followed, as it was in the newest frame.
struct PointTrack {
  FeatureId id = 0;
  std::uint32_t length = 1;  ///< frames, this one included
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  Eigen::Vector2d bearing = Eigen::Vector2d::Zero();          ///< on the plane z = 1
  Eigen::Vector2d bearing_rate_ps = Eigen::Vector2d::Zero();  ///< 1/s
  Eigen::Vector2d parallax_px = Eigen::Vector2d::Zero();      ///< last motion, rotation taken out
  Eigen::Vector2d parallax_pxps = Eigen::Vector2d::Zero();
  double flow_px = 0.0;                                       ///< length of the last motion
  Eigen::Matrix2d A_reference = Eigen::Matrix2d::Identity();  ///< offsets here to the first view
  ReferencePatches::Slot slot = 0;
  int strikes = 0;  ///< grows while the motion check disagrees
  bool inlier = true;
  /// Bearings of the last frames, at frame number % kTrackHistory.
  std::array<std::array<double, 2>, kTrackHistory> past_bearings{};
};

}  // namespace pled
