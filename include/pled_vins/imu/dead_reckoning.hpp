#pragma once

#include <cstddef>
#include <span>

#include "pled_vins/core/timestamp.hpp"
#include "pled_vins/geometry/pose.hpp"
#include "pled_vins/imu/imu_history.hpp"
#include "pled_vins/imu/preintegration.hpp"

namespace pled {

/// Where the body was shortly before a known state and will be shortly after it, by the IMU alone.
/// Ours: over some tenths of a second this path is smoother than what an estimator gave out frame
/// by frame, which also moves when the estimate is corrected.
///
/// @param known         state at known.t, with the biases to take off
/// @param gravity_mps2  magnitude; down is -z of the world
/// @param times         newest first; on either side of known.t
/// @param T_world_body  as many as times; poses at the first of them
/// @returns how many poses are given, newest first: fewer than times, and undefined after them,
/// when the inertial data do not lead further back (or have a gap there, or more than 512 samples
/// between two times); none when they do not lead to the times after known.t. Cost: one small step
/// a sample. Trapezoid in rate and in world acceleration.
[[nodiscard]] std::size_t dead_reckon(const ImuHistory& imu, const NavState& known,
                                      double gravity_mps2, std::span<const Timestamp> times,
                                      std::span<Pose> T_world_body) noexcept;

}  // namespace pled
