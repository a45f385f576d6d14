#include "pled_vins/backend/point_residual.hpp"

#include "pled_vins/geometry/so3.hpp"

namespace pled {
namespace {

constexpr double kMinScaledDepth = 0.02;

void fill_jacobians(const PointFrames& f, const Observation& seen, double rho, double s,
                    const Eigen::Vector3d& ray, const Eigen::Vector3d& b, const Eigen::Vector3d& q,
                    const Eigen::Vector3d& c, PointJacobians& J) {
  const Eigen::Matrix3d R_cj_b = f.T_body_cam_j.R().transpose();
  const Eigen::Matrix3d A = R_cj_b * f.T_world_body_j.R().transpose();  // R_cj_w
  const Eigen::Matrix3d B = A * f.T_world_body_i.R();                   // R_cj_bi
  const Eigen::Matrix3d T = B * f.T_body_cam_i.R();                     // R_cj_ci
  Eigen::Matrix<double, 2, 3> E;
  const double iz = s / c.z();
  E << iz, 0, -iz * c.x() / c.z(), 0, iz, -iz * c.y() / c.z();
  const Eigen::Matrix<double, 2, 3> EA = E * A;
  const Eigen::Matrix<double, 2, 3> EC = E * R_cj_b;
  J.pose_i.leftCols<3>() = rho * EA;
  J.pose_i.rightCols<3>() = -E * B * so3::skew(b);
  J.pose_j.leftCols<3>() = -rho * EA;
  J.pose_j.rightCols<3>() = EC * so3::skew(q);
  J.point.leftCols<2>() = (E * T).leftCols<2>();
  J.point.col(2) = E * (B * f.T_body_cam_i.p + A * (f.T_world_body_i.p - f.T_world_body_j.p) -
                        R_cj_b * f.T_body_cam_j.p);
  J.time_shift = s * Eigen::Vector2d(seen.rate_ps[0], seen.rate_ps[1]);
  if (!J.with_extrinsic) {
    J.extrinsic_i.setZero();
    J.extrinsic_j.setZero();
    return;
  }
  J.extrinsic_i.leftCols<3>() = rho * E * B;
  J.extrinsic_i.rightCols<3>() = -E * T * so3::skew(ray);
  J.extrinsic_j.leftCols<3>() = -rho * EC;
  J.extrinsic_j.rightCols<3>() = E * so3::skew(c);
}

}  // namespace

bool point_residual(const PointFrames& f, const std::array<double, 3>& point,
                    const Observation& seen, double time_shift_s, double sigmas_per_unit,
                    Eigen::Vector2d& residual, PointJacobians* jacobians) noexcept {
  const Eigen::Vector3d ray{point[0], point[1], 1.0};
  const double rho = point[2];
  const Eigen::Vector3d b = f.T_body_cam_i.q * ray + rho * f.T_body_cam_i.p;
  const Eigen::Vector3d w =
      f.T_world_body_i.q * b + rho * (f.T_world_body_i.p - f.T_world_body_j.p);
  const Eigen::Vector3d q = f.T_world_body_j.q.conjugate() * w;
  const Eigen::Vector3d qc = q - rho * f.T_body_cam_j.p;
  Eigen::Vector3d c = f.T_body_cam_j.q.conjugate() * qc;
  const bool in_front = c.z() > kMinScaledDepth;
  if (!in_front) c.z() = kMinScaledDepth;
  const Eigen::Vector2d measured{seen.xy[0] - time_shift_s * seen.rate_ps[0],
                                 seen.xy[1] - time_shift_s * seen.rate_ps[1]};
  residual = sigmas_per_unit * (c.head<2>() / c.z() - measured);
  if (jacobians) fill_jacobians(f, seen, rho, sigmas_per_unit, ray, b, q, c, *jacobians);
  return in_front;
}

void anchor_residual(const std::array<double, 3>& point, const Observation& seen,
                     double time_shift_s, double sigmas_per_unit, Eigen::Vector2d& residual,
                     PointJacobians* jacobians) noexcept {
  const double s = sigmas_per_unit;
  residual << s * (point[0] - seen.xy[0] + time_shift_s * seen.rate_ps[0]),
      s * (point[1] - seen.xy[1] + time_shift_s * seen.rate_ps[1]);
  if (!jacobians) return;
  PointJacobians& J = *jacobians;
  J.pose_i.setZero();
  J.pose_j.setZero();
  J.extrinsic_i.setZero();
  J.extrinsic_j.setZero();
  J.point << s, 0, 0, 0, s, 0;
  J.time_shift << s * seen.rate_ps[0], s * seen.rate_ps[1];
}

}  // namespace pled
