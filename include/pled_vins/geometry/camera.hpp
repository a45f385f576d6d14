#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/geometry/pose.hpp"

namespace pled {

enum class Distortion : std::uint8_t { kNone, kRadtan, kEquidistant };

/// One camera as Kalibr describes it: pinhole intrinsics, lens, place on the body.
struct CameraCalibration {
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;
  Distortion distortion = Distortion::kNone;
  /// radtan: k1 k2 p1 p2 k3; equidistant: k1 k2 k3 k4 and 0.
  std::array<double, 5> coeffs{};
  /// Camera coordinates to body (IMU) coordinates: the inverse of Kalibr's T_cam_imu.
  Pose T_body_cam;
  /// Kalibr's timeshift_cam_imu: t_imu = t_cam + time_shift_s.
  double time_shift_s = 0.0;
};

/// Continuous-time noise densities, as in Kalibr's imu.yaml.
struct ImuNoise {
  double accel_density = 0.01;  ///< m/s^2/sqrt(Hz)
  double accel_walk = 0.001;    ///< m/s^3/sqrt(Hz)
  double gyro_density = 0.001;  ///< rad/s/sqrt(Hz)
  double gyro_walk = 0.0001;    ///< rad/s^2/sqrt(Hz)
  double rate_hz = 200.0;
  double gravity_mps2 = 9.81;  ///< magnitude where the sensor is, 9.78 ... 9.83 on Earth
};

/// The robot's sensors. A DAVIS has one camera that serves both as the frame and
/// as the event camera.
struct RigCalibration {
  std::array<CameraCalibration, limits::kMaxCameras> cameras{};
  std::uint8_t num_cameras = 0;
  std::uint8_t frame_camera = 0;
  std::uint8_t event_camera = 0;
  ImuNoise imu;
};

/// Mean of the two focal lengths: what turns angles near the axis into pixels.
[[nodiscard]] inline double mean_focal_px(const CameraCalibration& camera) noexcept {
  return 0.5 * (camera.fx_px + camera.fy_px);
}

/// A projection model: between pixels as the sensor sees them and bearings.
/// Cheap to copy; no allocation.
class Camera {
 public:
  Camera() = default;
  /// Finds the lens model's turning radius; some hundred polynomial evaluations.
  explicit Camera(const CameraCalibration& calibration) noexcept;

  [[nodiscard]] const CameraCalibration& calibration() const noexcept { return c_; }

  /// Undistorted bearing (x, y) on the plane z = 1 to a raw pixel.
  [[nodiscard]] Eigen::Vector2d distort(const Eigen::Vector2d& bearing_xy) const noexcept;
  /// The same with d(raw_px) / d(bearing_xy).
  [[nodiscard]] Eigen::Vector2d distort(const Eigen::Vector2d& bearing_xy,
                                        Eigen::Matrix2d& d_px_d_xy) const noexcept;
  /// A point in camera coordinates (m) to a raw pixel; nullopt when z <= 1e-6 or when the lens
  /// model folds back there (beyond its turning radius).
  [[nodiscard]] std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_cam) const noexcept;
  /// Raw pixel to bearing (x, y) on the plane z = 1, by Newton; nullopt when it does not
  /// converge to 1e-9 in 20 steps inside the model's turning radius (far outside the lens model).
  [[nodiscard]] std::optional<Eigen::Vector2d> undistort(
      const Eigen::Vector2d& raw_px) const noexcept;
  /// Bearings |(x, y)| below this are inside the lens model, where a longer bearing means a
  /// pixel farther out. At most tan(89.9 deg).
  [[nodiscard]] double turning_radius() const noexcept { return turning_radius_; }
  /// Mean focal length, pixels.
  [[nodiscard]] double focal_px() const noexcept { return mean_focal_px(c_); }
  /// True when `raw_px` is at least `border_px` inside the image.
  [[nodiscard]] bool inside(const Eigen::Vector2d& raw_px, double border_px = 0.0) const noexcept {
    return raw_px.x() >= border_px && raw_px.y() >= border_px &&
           raw_px.x() <= c_.width_px - 1 - border_px && raw_px.y() <= c_.height_px - 1 - border_px;
  }

 private:
  [[nodiscard]] std::optional<Eigen::Vector2d> undistort_radtan(
      const Eigen::Vector2d& target_xy) const noexcept;
  [[nodiscard]] std::optional<Eigen::Vector2d> undistort_equidistant(
      const Eigen::Vector2d& target_xy) const noexcept;

  CameraCalibration c_;
  double turning_radius_ = 0.0;
};

}  // namespace pled
