#pragma once

#include <array>
#include <span>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/camera.hpp"

namespace pled {

/// Tells whether the rig stands: the IMU is quiet, and most points have not left the place
/// where they were when it became so.
class StillDetector {
 public:
  explicit StillDetector(const RigCalibration& rig) noexcept;

  /// @param imu  samples since the last frame.
  /// @returns true once the rig has stood for kMinStill.
  bool update(const FrameMeasurement& frame, std::span<const ImuSample> imu) noexcept;
  void reset() noexcept { num_reference_ = 0; }
  /// Since when it stands; meaningful after update() returned true.
  [[nodiscard]] Timestamp since() const noexcept { return since_; }

  static constexpr Duration kMinStill{400'000};

 private:
  struct Place {
    FeatureId id = 0;
    std::array<double, 2> xy{};
  };
  [[nodiscard]] bool quiet(std::span<const ImuSample> imu) const noexcept;
  [[nodiscard]] bool in_place(const FrameMeasurement& frame, std::size_t& common) const noexcept;
  void set_reference(const FrameMeasurement& frame) noexcept;

  double focal_px_ = 0;
  double gyro_std_radps_ = 0;
  double accel_std_mps2_ = 0;
  Timestamp since_;
  bool still_ = false;
  std::array<Place, limits::kMaxPoints> reference_{};
  std::size_t num_reference_ = 0;
};

}  // namespace pled
