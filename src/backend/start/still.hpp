#pragma once

#include "pled_vins/backend/start.hpp"
#include "src/backend/start/imu_path.hpp"
#include "src/backend/start/tracks.hpp"

namespace pled::start {

/// What standing still looks like.
struct Stillness {
  bool image_still = false;
  bool imu_still = false;
  double image_motion_px = 0;  ///< median over tracks, first to last sight, nothing removed
  double imu_motion_m = 0;     ///< largest excursion of the doubly integrated specific force
  double imu_turn_rad = 0;     ///< largest excursion of the integrated gyro about its mean
};

/// Judges the span of `path`, which must be integrated with zero biases. The picture is the
/// evidence (no rotation removed: a gyro bias of any size must not matter), the IMU the witness:
/// with its own mean taken out it must not have gone anywhere, whatever it vibrates.
[[nodiscard]] Stillness judge_stillness(const Tracks& tracks, const StartFrames& frames,
                                        const ImuHistory& imu, const RigCalibration& rig,
                                        const BackendConfig& config, ImuPath& path) noexcept;

}  // namespace pled::start
