#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/imu/preintegration.hpp"

namespace pled::support {

/// A hand that shakes a sensor: every axis turns at about 3 Hz, together near 4 rad/s, and moves at
/// 3 Hz on top of a slow walk. All derivatives in closed form.
class HandHeldMotion {
 public:
  /// Frequency of roll, pitch and yaw. Three equal ones make a steady cone, the worst case for an
  /// integrator: its error then grows in one direction.
  explicit HandHeldMotion(const Eigen::Vector3d& turn_hz)
      : turn_radps_(2.0 * std::numbers::pi * turn_hz) {}

  [[nodiscard]] NavState state(double t_s) const {
    NavState s;
    s.t = Timestamp{std::llround(t_s * 1e6)};
    const double wt = kShake_radps * t_s;
    const double ut = kWalk_radps * t_s;
    s.p_wb = kShake_m * Eigen::Vector3d(std::sin(wt), std::sin(wt + 1.0), std::sin(wt + 2.0)) +
             kWalk_m * Eigen::Vector3d(std::sin(ut), std::cos(ut), 0.3 * std::sin(2.0 * ut));
    s.v_wb = kShake_m * kShake_radps *
                 Eigen::Vector3d(std::cos(wt), std::cos(wt + 1.0), std::cos(wt + 2.0)) +
             kWalk_m * kWalk_radps *
                 Eigen::Vector3d(std::cos(ut), -std::sin(ut), 0.6 * std::cos(2.0 * ut));
    const Eigen::Vector3d e = angles(t_s);
    s.q_wb = Eigen::AngleAxisd(e.z(), Eigen::Vector3d::UnitZ()) *
             Eigen::AngleAxisd(e.y(), Eigen::Vector3d::UnitY()) *
             Eigen::AngleAxisd(e.x(), Eigen::Vector3d::UnitX());
    return s;
  }

  /// What an ideal IMU reads, biases not added.
  [[nodiscard]] ImuSample imu(double t_s) const {
    const double wt = kShake_radps * t_s;
    const double ut = kWalk_radps * t_s;
    const Eigen::Vector3d a_w =
        -kShake_m * kShake_radps * kShake_radps *
            Eigen::Vector3d(std::sin(wt), std::sin(wt + 1.0), std::sin(wt + 2.0)) -
        kWalk_m * kWalk_radps * kWalk_radps *
            Eigen::Vector3d(std::sin(ut), std::cos(ut), 1.2 * std::sin(2.0 * ut));
    const NavState s = state(t_s);
    const Eigen::Vector3d f = s.q_wb.conjugate() * (a_w - kGravityWorld);
    const Eigen::Vector3d e = angles(t_s);
    const Eigen::Vector3d d =
        kShake_rad * turn_radps_.cwiseProduct((turn_radps_ * t_s + phase()).array().cos().matrix());
    // Body rate of R = Rz(yaw) Ry(pitch) Rx(roll).
    const Eigen::Vector3d w(d.x() - d.z() * std::sin(e.y()),
                            d.y() * std::cos(e.x()) + d.z() * std::cos(e.y()) * std::sin(e.x()),
                            -d.y() * std::sin(e.x()) + d.z() * std::cos(e.y()) * std::cos(e.x()));
    ImuSample out;
    out.t = s.t;
    out.gyro_radps = {w.x(), w.y(), w.z()};
    out.accel_mps2 = {f.x(), f.y(), f.z()};
    return out;
  }

 private:
  static constexpr double kShake_radps = 2.0 * std::numbers::pi * 3.0;
  static constexpr double kShake_rad = 0.17;  // peak rate of one axis 3.2 rad/s, of all 4 rad/s
  static constexpr double kShake_m = 0.02;
  static constexpr double kWalk_radps = 2.0 * std::numbers::pi * 0.2;
  static constexpr double kWalk_m = 0.5;
  static constexpr double kPhase = 2.0 * std::numbers::pi / 3.0;

  [[nodiscard]] static Eigen::Vector3d phase() { return {0.0, kPhase, 2.0 * kPhase}; }
  [[nodiscard]] Eigen::Vector3d angles(double t_s) const {
    return kShake_rad * (turn_radps_ * t_s + phase()).array().sin().matrix();
  }

  Eigen::Vector3d turn_radps_;
};

}  // namespace pled::support
