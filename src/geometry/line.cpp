#include "pled_vins/geometry/line.hpp"

#include <cmath>

#include "pled_vins/geometry/so3.hpp"

namespace pled {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMaxSlant = 1e-6;          // of n . d, far above rounding, far below an error
constexpr double kMinDistance_m = 1e-9;     // of a line from the camera that sees it
constexpr double kMinSine = 1e-9;           // below it directions count as parallel
constexpr double kNothing = 1e-14;          // of the shorter against the longer vector: rounding
constexpr double kMinPictureNormal = 1e-6;  // sine of the angle of a line's plane with z = 1

/// `shorter` made perpendicular to the unit vector `u`, as a unit vector and its length. Any
/// perpendicular with length 0 when nothing is left but rounding.
Vector3d perpendicular(const Vector3d& shorter, const Vector3d& u, double longer_norm,
                       double& length) noexcept {
  const Vector3d across = shorter - u * u.dot(shorter);
  length = across.norm();
  if (length > kNothing * longer_norm) return across / length;
  length = 0.0;
  return u.unitOrthogonal();
}

}  // namespace

PluckerLine line_through(const Vector3d& a, const Vector3d& b) noexcept {
  return {a.cross(b), b - a};
}

PluckerLine operator*(const Pose& T_a_b, const PluckerLine& line_b) noexcept {
  const Vector3d d = T_a_b.q * line_b.d;
  return {T_a_b.q * line_b.n + T_a_b.p.cross(d), d};
}

std::optional<OrthonormalLine> to_orthonormal(const PluckerLine& line) noexcept {
  double n = line.n.norm();
  double d = line.d.norm();
  if (!(n + d > 0.0) || !std::isfinite(n + d)) return std::nullopt;
  if (!(std::abs(line.n.dot(line.d)) <= kMaxSlant * d * (n + d))) return std::nullopt;
  Eigen::Matrix3d U;
  if (n > d) {
    U.col(0) = line.n / n;
    U.col(1) = perpendicular(line.d, U.col(0), n, d);
  } else {
    U.col(1) = line.d / d;
    U.col(0) = perpendicular(line.n, U.col(1), d, n);
  }
  U.col(2) = U.col(0).cross(U.col(1));
  return OrthonormalLine{Eigen::Quaterniond(U).normalized(), std::atan2(d, n)};
}

PluckerLine to_plucker(const OrthonormalLine& line) noexcept {
  const Eigen::Matrix3d U = line.U.toRotationMatrix();
  return {std::cos(line.phi_rad) * U.col(0), std::sin(line.phi_rad) * U.col(1)};
}

OrthonormalLine box_plus(const OrthonormalLine& line, const LineTangent& delta) noexcept {
  return {(line.U * so3::exp(delta.head<3>())).normalized(), line.phi_rad + delta[3]};
}

LineTangent box_minus(const OrthonormalLine& to, const OrthonormalLine& from) noexcept {
  LineTangent delta;
  delta << so3::log(from.U.conjugate() * to.U), to.phi_rad - from.phi_rad;
  return delta;
}

Eigen::Matrix<double, 6, 4> plucker_jacobian(const OrthonormalLine& line) noexcept {
  const Eigen::Matrix3d U = line.U.toRotationMatrix();
  const double w1 = std::cos(line.phi_rad);
  const double w2 = std::sin(line.phi_rad);
  const Vector3d zero = Vector3d::Zero();
  Eigen::Matrix<double, 6, 4> J;
  J << zero, -w1 * U.col(2), w1 * U.col(1), -w2 * U.col(0),  //
      w2 * U.col(2), zero, -w2 * U.col(0), w1 * U.col(1);
  return J;
}

std::optional<Vector3d> project(const PluckerLine& line_cam) noexcept {
  const double n = line_cam.n.norm();
  const double m = line_cam.n.head<2>().norm();
  if (!(n > kMinDistance_m * line_cam.d.norm()) || !(m > kMinPictureNormal * n)) {
    return std::nullopt;
  }
  const Vector3d l = line_cam.n / m;
  if (!l.allFinite()) return std::nullopt;
  return l;
}

std::optional<Vector3d> point_seen_at(const PluckerLine& line_cam, const Vector2d& xy) noexcept {
  const std::optional<Vector3d> l = project(line_cam);
  if (!l) return std::nullopt;
  // The plane through the camera's centre that meets the picture at xy, across the line:
  // pi . x = 0 and n = x cross d give x (pi . d) = pi cross n.
  const Vector3d pi = xy.homogeneous().cross(Vector3d(l->x(), l->y(), 0.0));
  const double along = pi.dot(line_cam.d);
  if (!(std::abs(along) > kMinSine * pi.norm() * line_cam.d.norm())) return std::nullopt;
  const Vector3d x = pi.cross(line_cam.n) / along;
  if (!(x.z() > 0.0) || !x.allFinite()) return std::nullopt;
  return x;
}

std::optional<Vector3d> nearest_point(const PluckerLine& line, const Vector3d& p) noexcept {
  const double d2 = line.d.squaredNorm();
  const Vector3d from_p = line.n - p.cross(line.d);  // the moment about p
  const Vector3d x = p + line.d.cross(from_p) / d2;
  if (!(d2 > 0.0) || !x.allFinite()) return std::nullopt;
  return x;
}

std::optional<NearestPoints> nearest_points(const PluckerLine& a, const PluckerLine& b) noexcept {
  const Vector3d c = a.d.cross(b.d);
  const double c2 = c.squaredNorm();
  if (!(c.norm() > kMinSine * a.d.norm() * b.d.norm())) return std::nullopt;
  // Each point is where its line meets the plane through the other line along c: for a, the plane
  // with normal b.d cross c.
  const NearestPoints out{(b.d.cross(c).cross(a.n) + b.n.dot(c) * a.d) / c2,
                          (a.d.cross(-c).cross(b.n) - a.n.dot(c) * b.d) / c2};
  if (!out.on_a.allFinite() || !out.on_b.allFinite()) return std::nullopt;
  return out;
}

}  // namespace pled
