#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace pled {

/// A rigid transform. `T_a_b` takes coordinates of frame b to frame a:
/// p_a = T_a_b * p_b. Neighbouring frames must match: T_a_b * T_b_c.
struct Pose {
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();  ///< metres

  [[nodiscard]] Eigen::Matrix3d R() const noexcept { return q.toRotationMatrix(); }
  [[nodiscard]] Pose inverse() const noexcept {
    const Eigen::Quaterniond qi = q.conjugate();
    return {qi, -(qi * p)};
  }
  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& v) const noexcept {
    return q * v + p;
  }
  [[nodiscard]] Pose operator*(const Pose& o) const noexcept {
    return {(q * o.q).normalized(), q * o.p + p};
  }
};

}  // namespace pled
