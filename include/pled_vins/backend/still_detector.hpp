#pragma once

#include <array>
#include <span>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/imu/preintegration.hpp"

namespace pled {

/// Tells whether the rig stands: the IMU is quiet, or shaken by motors while the estimate neither
/// moves nor turns; and the picture has not left the place where it was when that began.
class StillDetector {
 public:
  explicit StillDetector(const RigCalibration& rig) noexcept;

  /// @param imu        samples since the last frame.
  /// @param predicted  the state at the frame by the IMU alone.
  /// @returns true once the rig has stood for kMinStill; after it was seen to leave its place, for
  ///          kMinStillAgain, in which a rig that creeps leaves the place anew.
  bool update(const FrameMeasurement& frame, std::span<const ImuSample> imu,
              const NavState& predicted) noexcept;
  void reset() noexcept;
  /// Starts anew with a rig that is known to have stood since then.
  void begin(const FrameMeasurement& frame, std::span<const ImuSample> imu, const NavState& state,
             Timestamp since) noexcept;
  /// Since when it stands; meaningful after update() returned true.
  [[nodiscard]] Timestamp since() const noexcept { return since_; }

  static constexpr Duration kMinStill{400'000};
  static constexpr Duration kMinStillAgain{1'000'000};

 private:
  struct Place {
    FeatureId id = 0;
    std::array<double, 2> xy{};
    Timestamp since;
    Eigen::Vector3d shaken_rad = Eigen::Vector3d::Zero();  ///< by motors, at that time
  };
  [[nodiscard]] bool quiet(std::span<const ImuSample> imu, const NavState& predicted) noexcept;
  [[nodiscard]] bool in_place(const FrameMeasurement& frame, std::size_t& common) noexcept;
  void set_reference(const FrameMeasurement& frame) noexcept;

  double focal_px_ = 0;
  Eigen::Quaterniond q_bc_;
  double gyro_std_radps_ = 0;
  double accel_std_mps2_ = 0;
  Eigen::Vector3d shaken_rad_ = Eigen::Vector3d::Zero();
  Timestamp since_;
  Duration wait_ = kMinStill;
  bool still_ = false;
  std::array<Place, limits::kMaxPoints> reference_{};
  std::array<Place, limits::kMaxPoints> last_reference_{};
  std::size_t num_reference_ = 0;
  std::array<std::array<double, limits::kMaxPoints>, 3> shifts_px_{};
};

}  // namespace pled
