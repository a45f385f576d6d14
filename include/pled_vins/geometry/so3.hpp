#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

/// Rotations. Hamilton quaternions, perturbation on the right: R (+) phi = R Exp(phi).
namespace pled::so3 {

/// [v]x, so that skew(a) * b = a x b.
[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& v) noexcept;

/// Exp: rotation vector (rad) to unit quaternion. Exact to rounding for any angle, 0 included.
[[nodiscard]] Eigen::Quaterniond exp(const Eigen::Vector3d& phi) noexcept;

/// Log: unit quaternion to the rotation vector (rad) with angle in [0, pi].
[[nodiscard]] Eigen::Vector3d log(const Eigen::Quaterniond& q) noexcept;

/// J_r(phi): Exp(phi + d) = Exp(phi) Exp(J_r d) to first order in d.
[[nodiscard]] Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& phi) noexcept;

/// Inverse of J_r: Log(Exp(phi) Exp(d)) = phi + J_r^-1 d to first order in d.
[[nodiscard]] Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& phi) noexcept;

/// The rotation R by the smallest angle that turns the direction of `from` into that of `to`:
/// R * from is parallel to `to`. Lengths do not matter, but neither may be zero. Opposite
/// directions have no unique answer: the axis is then some fixed perpendicular of `from`.
[[nodiscard]] Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from,
                                                  const Eigen::Vector3d& to) noexcept;

}  // namespace pled::so3
