#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "pled_vins/backend/start.hpp"
#include "src/backend/start/tracks.hpp"

namespace pled::start {

/// Where frame k stands relative to the body at frame 0 (frame "0"), as far as the IMU alone tells:
/// p_k = v_0 t + 1/2 g t^2 + alpha, v_k = v_0 + g t + beta, everything in frame 0.
struct PathPoint {
  double t_s = 0;  ///< since frame 0
  Eigen::Matrix3d R_0k = Eigen::Matrix3d::Identity();
  Eigen::Vector3d alpha = Eigen::Vector3d::Zero();         ///< m
  Eigen::Vector3d beta = Eigen::Vector3d::Zero();          ///< m/s
  Eigen::Matrix3d d_theta_d_bg = Eigen::Matrix3d::Zero();  ///< right tangent of R_0k
  Eigen::Matrix3d d_alpha_d_bg = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d d_alpha_d_ba = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d d_beta_d_bg = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d d_beta_d_ba = Eigen::Matrix3d::Zero();
};

/// Integrates the IMU once through all frames, exact in the biases it is given, with derivatives by
/// the biases. Ours: Simpson's rule over each IMU step with linear specific force.
class ImuPath {
 public:
  /// kNone, kNoImu, kImuGap. The points are meaningless unless kNone.
  [[nodiscard]] StartRefusal integrate(const StartFrames& frames, const ImuHistory& imu,
                                       const Eigen::Vector3d& bg,
                                       const Eigen::Vector3d& ba) noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] const PathPoint& operator[](std::size_t k) const noexcept { return points_[k]; }
  /// Of the samples integrated: plain means and standard deviations (norm over axes).
  [[nodiscard]] const Eigen::Vector3d& mean_gyro() const noexcept { return mean_gyro_; }
  [[nodiscard]] const Eigen::Vector3d& mean_accel() const noexcept { return mean_accel_; }
  [[nodiscard]] double gyro_std() const noexcept { return gyro_std_; }
  [[nodiscard]] double accel_std() const noexcept { return accel_std_; }

 private:
  void advance(PathPoint& x, const ImuSample& a, const ImuSample& b, const Eigen::Vector3d& bg,
               const Eigen::Vector3d& ba) const noexcept;

  std::array<PathPoint, kMaxFrames> points_{};
  std::array<ImuSample, 512> buffer_{};  ///< of one frame interval
  std::size_t size_ = 0;
  Eigen::Vector3d mean_gyro_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_accel_ = Eigen::Vector3d::Zero();
  double gyro_std_ = 0;
  double accel_std_ = 0;
};

}  // namespace pled::start
