#include "pled_vins/geometry/so3.hpp"

#include <cmath>

namespace pled::so3 {
namespace {

// Below this squared angle the closed forms lose digits to cancellation and the Taylor series,
// cut where its next term is below 1e-15, takes over.
constexpr double kSeriesBelow = 1e-2;

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& v) noexcept {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(),  //
      v.z(), 0.0, -v.x(),   //
      -v.y(), v.x(), 0.0;
  return m;
}

Eigen::Quaterniond exp(const Eigen::Vector3d& phi) noexcept {
  const double half = 0.5 * phi.norm();
  const double h2 = half * half;
  // sin(half) / (2 half)
  const double k = h2 < kSeriesBelow * kSeriesBelow
                       ? 0.5 * (1.0 - h2 / 6.0 * (1.0 - h2 / 20.0 * (1.0 - h2 / 42.0)))
                       : 0.5 * std::sin(half) / half;
  return {std::cos(half), k * phi.x(), k * phi.y(), k * phi.z()};
}

Eigen::Vector3d log(const Eigen::Quaterniond& q) noexcept {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;  // q and -q are one rotation; take the short way
  const double w = sign * q.w();
  const double n = q.vec().norm();
  // atan2 is accurate for all angles, pi included (w = 0), where acos would not be.
  const double k = n < 1e-6 ? 2.0 / w * (1.0 - n * n / (3.0 * w * w)) : 2.0 * std::atan2(n, w) / n;
  return sign * k * q.vec();
}

Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& phi) noexcept {
  const double t = phi.squaredNorm();
  double a = 0.0;  // (1 - cos) / angle^2
  double b = 0.0;  // (angle - sin) / angle^3
  if (t < kSeriesBelow) {
    a = 0.5 - t * (1.0 / 24.0 - t * (1.0 / 720.0 - t * (1.0 / 40320.0 - t / 3628800.0)));
    b = 1.0 / 6.0 - t * (1.0 / 120.0 - t * (1.0 / 5040.0 - t * (1.0 / 362880.0 - t / 39916800.0)));
  } else {
    const double angle = std::sqrt(t);
    const double s = std::sin(0.5 * angle);
    a = 2.0 * s * s / t;
    b = (angle - std::sin(angle)) / (t * angle);
  }
  const Eigen::Matrix3d k = skew(phi);
  return Eigen::Matrix3d::Identity() - a * k + b * k * k;
}

Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& phi) noexcept {
  const double t = phi.squaredNorm();
  double c = 0.0;  // (1 - (angle / 2) cot(angle / 2)) / angle^2, finite at pi
  if (t < kSeriesBelow) {
    c = 1.0 / 12.0 +
        t * (1.0 / 720.0 + t * (1.0 / 30240.0 + t * (1.0 / 1209600.0 + t / 47900160.0)));
  } else {
    const double half = 0.5 * std::sqrt(t);
    c = (1.0 - half * std::cos(half) / std::sin(half)) / t;
  }
  const Eigen::Matrix3d k = skew(phi);
  return Eigen::Matrix3d::Identity() + 0.5 * k + c * k * k;
}

Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from,
                                    const Eigen::Vector3d& to) noexcept {
  const Eigen::Vector3d a = from.normalized();
  const Eigen::Vector3d b = to.normalized();
  const Eigen::Vector3d cross = a.cross(b);
  const double sine = cross.norm();
  const double cosine = a.dot(b);
  if (sine < 1e-14 && cosine > 0.0) return Eigen::Quaterniond::Identity();
  Eigen::Vector3d axis = cross;
  if (sine < 1e-14) {
    Eigen::Index smallest = 0;
    a.cwiseAbs().minCoeff(&smallest);
    axis = a.cross(Eigen::Vector3d::Unit(smallest));
  }
  axis.normalize();
  // Near opposite directions the cross product is nearly all rounding; only an axis that is
  // exactly perpendicular to `a` still turns it onto `b`.
  axis -= a * a.dot(axis);
  axis.normalize();
  return exp(axis * std::atan2(sine, cosine));
}

}  // namespace pled::so3
