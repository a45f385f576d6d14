#pragma once

#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/camera.hpp"

namespace pled {

/// Standard gravity in the world frame (z up), m/s^2: what is assumed where nobody says otherwise.
inline const Eigen::Vector3d kGravityWorld{0.0, 0.0, -9.81};

/// Body state at an instant. Tangent order: p, theta, v, bg, ba (15); rotation
/// perturbed on the right.
struct NavState {
  Timestamp t;
  Eigen::Vector3d p_wb = Eigen::Vector3d::Zero();  ///< m
  Eigen::Quaterniond q_wb = Eigen::Quaterniond::Identity();
  Eigen::Vector3d v_wb = Eigen::Vector3d::Zero();  ///< m/s
  Eigen::Vector3d bg = Eigen::Vector3d::Zero();    ///< gyro bias, rad/s
  Eigen::Vector3d ba = Eigen::Vector3d::Zero();    ///< accelerometer bias, m/s^2

  [[nodiscard]] Pose T_world_body() const noexcept { return {q_wb, p_wb}; }
};

using Matrix15d = Eigen::Matrix<double, 15, 15>;
using Vector15d = Eigen::Matrix<double, 15, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Vector9d = Eigen::Matrix<double, 9, 1>;

/// IMU samples of one interval summed up on the manifold (Forster et al., TRO 2017),
/// independent of the state at its start; first-order corrections for biases.
///
/// Differs: the signal between two samples is the cubic through them and their neighbours, and
/// each step is of 4th order in rotation (Magnus), velocity and position (Simpson): coning and
/// sculling included. Cost: about 2 us per sample (x86-64, -O3). No allocation.
///
/// Error order of the covariance and of the residual: p, theta, v, bg, ba (15).
class Preintegration {
 public:
  Preintegration() = default;

  /// Integrates `samples` (strictly increasing stamps, >= 2; first and last are the
  /// ends of the interval) with the given biases. False, leaving an empty
  /// preintegration, when there are fewer than 2, stamps do not increase, a value is not
  /// finite, or a noise density is not > 0.
  bool integrate(std::span<const ImuSample> samples, const Eigen::Vector3d& bg,
                 const Eigen::Vector3d& ba, const ImuNoise& noise) noexcept;

  [[nodiscard]] double dt_s() const noexcept { return dt_s_; }
  [[nodiscard]] bool empty() const noexcept { return !(dt_s_ > 0); }

  /// Increments corrected to first order for biases bg, ba.
  [[nodiscard]] Eigen::Quaterniond delta_q(const Eigen::Vector3d& bg) const noexcept;
  [[nodiscard]] Eigen::Vector3d delta_v(const Eigen::Vector3d& bg,
                                        const Eigen::Vector3d& ba) const noexcept;
  [[nodiscard]] Eigen::Vector3d delta_p(const Eigen::Vector3d& bg,
                                        const Eigen::Vector3d& ba) const noexcept;

  /// State at the end from the state at the start; biases carried over. Gravity is the noise
  /// model's gravity_mps2, down.
  [[nodiscard]] NavState predict(const NavState& start) const noexcept;

  /// Residual (15, not whitened): rp = R_i^T (p_j - p_i - v_i dt - 1/2 g dt^2) - dp,
  /// rtheta = Log(dq^-1 R_i^T R_j), rv = R_i^T (v_j - v_i - g dt) - dv, rbg = bg_j - bg_i,
  /// rba = ba_j - ba_i, with increments corrected for bg_i, ba_i; and its Jacobians by the
  /// tangent of each state (15 x 15), when asked for (null: skipped).
  void residual(const NavState& i, const NavState& j, Vector15d& r, Matrix15d* d_r_d_i,
                Matrix15d* d_r_d_j) const noexcept;

  /// Covariance of the residual (15 x 15), from continuous noise densities.
  [[nodiscard]] const Matrix15d& covariance() const noexcept { return covariance_; }
  /// S with S^T S = covariance^-1, lower triangular: multiply the residual and Jacobians by it.
  [[nodiscard]] const Matrix15d& sqrt_information() const noexcept { return sqrt_information_; }

  [[nodiscard]] const Eigen::Vector3d& linearised_bg() const noexcept { return bg_; }
  [[nodiscard]] const Eigen::Vector3d& linearised_ba() const noexcept { return ba_; }

 private:
  [[nodiscard]] bool finish() noexcept;

  double dt_s_ = 0.0;
  Eigen::Vector3d gravity_ = kGravityWorld;  ///< world, m/s^2
  Eigen::Vector3d bg_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d ba_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond delta_q_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d delta_v_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d delta_p_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d d_q_d_bg_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d d_v_d_bg_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d d_v_d_ba_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d d_p_d_bg_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d d_p_d_ba_ = Eigen::Matrix3d::Zero();
  Matrix15d covariance_ = Matrix15d::Zero();
  Matrix15d sqrt_information_ = Matrix15d::Zero();
};

/// x (+) d and y (-) x, so that x (+) (y (-) x) = y.
[[nodiscard]] NavState box_plus(const NavState& x, const Vector15d& d) noexcept;
[[nodiscard]] Vector15d box_minus(const NavState& y, const NavState& x) noexcept;

}  // namespace pled
