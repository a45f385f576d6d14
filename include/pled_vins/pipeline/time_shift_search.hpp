#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/imu/imu_history.hpp"

namespace pled {

/// Finds a gross offset between the clocks of camera and IMU, by comparing how the picture turns
/// with how the gyro says it turns. Ours: a wrong or missing timeshift_cam_imu of a few hundredths
/// of a second is the commonest reason why a sound rig does not start, and nothing else shows it.
///
/// It needs neither the extrinsic calibration nor the gyro's bias: image rates are fitted as any
/// linear map of the gyro's plus a constant, at every offset tried. Fixed memory, no allocation.
class TimeShiftSearch {
 public:
  /// One interval between frames, both ends on the estimator's clock; `frame` was taken at `to`.
  /// Points of other cameras than `camera` do not count: each may have a clock of its own.
  void observe(Timestamp from, Timestamp to, const FrameMeasurement& frame,
               std::uint8_t camera) noexcept;

  /// What must be added to the frames' times; nullopt as long as the data do not tell, which
  /// includes an offset too small to prevent a start. Under a millisecond.
  [[nodiscard]] std::optional<Duration> find(const ImuHistory& imu) const noexcept;

  void reset() noexcept { size_ = 0; }

 private:
  static constexpr std::size_t kIntervals = 96;
  struct Turn {
    Timestamp from;
    Timestamp to;
    Eigen::Vector3d rate_radps;  ///< of the picture, camera frame
  };

  std::array<Turn, kIntervals> turns_;  ///< oldest first
  std::size_t size_ = 0;
};

}  // namespace pled
