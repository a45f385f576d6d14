#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/events/turn_history.hpp"
#include "pled_vins/geometry/so3.hpp"

namespace pled::support {

/// A body that turns about z by a(t) and about its own x by b(t), both sines on top of a steady
/// turn: orientation and angular rate in closed form.
struct TurningBody {
  double steady_radps = 3.0;
  double swing_rad = 0.2;
  double swing_hz = 2.0;

  [[nodiscard]] double angle(double t_s, double phase) const {
    return steady_radps * t_s + swing_rad * std::sin(6.283185307179586 * swing_hz * t_s + phase);
  }
  [[nodiscard]] double rate(double t_s, double phase) const {
    const double w = 6.283185307179586 * swing_hz;
    return steady_radps + swing_rad * w * std::cos(w * t_s + phase);
  }
  [[nodiscard]] Eigen::Quaterniond R_world_body(double t_s) const {
    return so3::exp({0, 0, angle(t_s, 0.0)}) * so3::exp({angle(t_s, 1.0), 0, 0});
  }
  [[nodiscard]] Eigen::Vector3d gyro_radps(double t_s) const {
    const Eigen::Vector3d about_z(0, 0, rate(t_s, 0.0));
    return so3::exp({angle(t_s, 1.0), 0, 0}).conjugate() * about_z +
           Eigen::Vector3d(rate(t_s, 1.0), 0, 0);
  }
  /// Camera coordinates at t_b to those at t_a.
  [[nodiscard]] Eigen::Quaterniond R_a_b(std::int64_t a_us, std::int64_t b_us,
                                         const Eigen::Quaterniond& R_body_cam) const {
    const Eigen::Quaterniond a = R_world_body(static_cast<double>(a_us) * 1e-6) * R_body_cam;
    const Eigen::Quaterniond b = R_world_body(static_cast<double>(b_us) * 1e-6) * R_body_cam;
    return a.conjugate() * b;
  }
  /// Samples every `step_us` over [from, to], with a bias added.
  [[nodiscard]] std::vector<ImuSample> samples(
      std::int64_t from_us, std::int64_t to_us, std::int64_t step_us,
      const Eigen::Vector3d& bias_radps = Eigen::Vector3d::Zero()) const {
    std::vector<ImuSample> out;
    for (std::int64_t t = from_us; t <= to_us; t += step_us) {
      const Eigen::Vector3d w = gyro_radps(static_cast<double>(t) * 1e-6) + bias_radps;
      out.push_back({{t}, {w.x(), w.y(), w.z()}, {}});
    }
    return out;
  }
};

/// A rotation between body and camera that is no multiple of 90 degrees.
[[nodiscard]] inline Eigen::Quaterniond slanted_mount() { return so3::exp({0.4, -1.2, 0.7}); }

}  // namespace pled::support
