#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/imu/imu_history.hpp"

namespace pled {

/// The gyro's bias as long as the back end has not started: its mean reading
/// while the picture stands still. Ours: without it a large bias (0.08 rad/s on
/// EuRoC) moves the predicted tracks of a resting robot by pixels.
class StillGyroBias {
 public:
  /// Looks at the interval between two frames; `median_flow_px` is the image
  /// motion in it, of `points` points.
  void observe(const ImuHistory& imu, Timestamp from, Timestamp to, double median_flow_px,
               std::size_t points) noexcept;
  /// Zero until a still interval was seen.
  [[nodiscard]] const Eigen::Vector3d& gyro_bias_radps() const noexcept { return bias_; }
  void reset() noexcept { *this = StillGyroBias{}; }

 private:
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  std::uint32_t intervals_ = 0;
};

}  // namespace pled
