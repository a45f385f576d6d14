#include "pled_vins/backend/line_residual.hpp"

#include "pled_vins/geometry/so3.hpp"

namespace pled {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFarthestPicture = 50.0;
constexpr double kMinPictureNormal = 1.0 / kFarthestPicture;
constexpr double kMinDistance_m = 1e-6;  // of the line from the camera's centre

/// The line's moment and direction on the way from the world to the camera.
struct LineInFrames {
  Vector3d p;  ///< of the body from the line's origin
  PluckerLine world;
  PluckerLine body;
  Vector3d n_cam;
};

LineInFrames transform(const LineFrames& f, const OrthonormalLine& line) {
  LineInFrames out;
  out.p = f.T_world_body.p - f.origin_world;
  out.world = to_plucker(line);
  out.body.n = f.T_world_body.q.conjugate() * (out.world.n - out.p.cross(out.world.d));
  out.body.d = f.T_world_body.q.conjugate() * out.world.d;
  out.n_cam = f.T_body_cam.q.conjugate() * (out.body.n - f.T_body_cam.p.cross(out.body.d));
  return out;
}

bool refuse(double sigmas_per_unit, Vector2d& residual, LineJacobians* jacobians) {
  residual.setConstant(kFarthestPicture * sigmas_per_unit);
  if (!jacobians) return false;
  jacobians->pose.setZero();
  jacobians->extrinsic.setZero();
  jacobians->line.setZero();
  jacobians->time_shift.setZero();
  return false;
}

/// By the chain rule through n_c, with
///   dn_b = R^T (dn_w - p x dd_w) + R^T [d_w]x dp + [n_b]x dtheta,  dd_b = R^T dd_w + [d_b]x
///   dtheta, dn_c = R_cb (dn_b - t x dd_b) + R_cb [d_b]x dt + [n_c]x dtheta_bc.
void fill_jacobians(const LineFrames& f, const OrthonormalLine& line, const LineInFrames& in,
                    const Eigen::Matrix<double, 2, 3>& d_r_d_n, LineJacobians& J) {
  const Eigen::Matrix<double, 2, 3> d_n = d_r_d_n * f.T_body_cam.R().transpose();  // by n_b
  const Eigen::Matrix<double, 2, 3> d_d = -d_n * so3::skew(f.T_body_cam.p);        // by d_b
  const Eigen::Matrix3d R_b_w = f.T_world_body.R().transpose();
  const Eigen::Matrix<double, 2, 3> d_n_w = d_n * R_b_w;
  const Eigen::Matrix<double, 2, 3> d_d_w = d_d * R_b_w - d_n_w * so3::skew(in.p);
  J.pose.leftCols<3>() = d_n_w * so3::skew(in.world.d);
  J.pose.rightCols<3>() = d_n * so3::skew(in.body.n) + d_d * so3::skew(in.body.d);
  const Eigen::Matrix<double, 6, 4> d_line = plucker_jacobian(line);
  J.line = d_n_w * d_line.topRows<3>() + d_d_w * d_line.bottomRows<3>();
  if (!J.with_extrinsic) {
    J.extrinsic.setZero();
    return;
  }
  J.extrinsic.leftCols<3>() = d_n * so3::skew(in.body.d);
  J.extrinsic.rightCols<3>() = d_r_d_n * so3::skew(in.n_cam);
}

}  // namespace

bool line_residual(const LineFrames& f, const OrthonormalLine& line, const LineObservation& seen,
                   double time_shift_s, double sigmas_per_unit, Vector2d& residual,
                   LineJacobians* jacobians) noexcept {
  const LineInFrames in = transform(f, line);
  const double n = in.n_cam.norm();
  const double m = in.n_cam.head<2>().norm();
  if (!(n > kMinDistance_m * in.body.d.norm()) || !(m > kMinPictureNormal * n)) {
    return refuse(sigmas_per_unit, residual, jacobians);
  }
  const Vector3d start{seen.start_xy[0] - time_shift_s * seen.start_rate_ps[0],
                       seen.start_xy[1] - time_shift_s * seen.start_rate_ps[1], 1.0};
  const Vector3d end{seen.end_xy[0] - time_shift_s * seen.end_rate_ps[0],
                     seen.end_xy[1] - time_shift_s * seen.end_rate_ps[1], 1.0};
  const double s = sigmas_per_unit / m;
  const Vector2d r = s * Vector2d(start.dot(in.n_cam), end.dot(in.n_cam));
  if (!r.allFinite()) return refuse(sigmas_per_unit, residual, jacobians);
  residual = r;
  if (!jacobians) return true;
  Eigen::Matrix<double, 2, 3> d_r_d_n;
  d_r_d_n << s * start.transpose(), s * end.transpose();
  d_r_d_n.leftCols<2>() -= r * (in.n_cam.head<2>().transpose() / (m * m));
  fill_jacobians(f, line, in, d_r_d_n, *jacobians);
  const Vector2d normal = s * in.n_cam.head<2>();
  jacobians->time_shift << -normal.dot(Vector2d(seen.start_rate_ps[0], seen.start_rate_ps[1])),
      -normal.dot(Vector2d(seen.end_rate_ps[0], seen.end_rate_ps[1]));
  return true;
}

}  // namespace pled
