#include "pled_vins/frontend/epipolar_fit.hpp"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "pled_vins/geometry/so3.hpp"

namespace pled {
namespace {

constexpr int kSteps = 6;
constexpr double kCauchy_px = 0.7;
constexpr double kLeastNormal = 1e-9;

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

/// Two unit vectors that are orthogonal to `t` and to each other.
Eigen::Matrix<double, 3, 2> tangents(const Eigen::Vector3d& t) noexcept {
  Eigen::Matrix<double, 3, 2> B;
  B.col(0) = t.unitOrthogonal();
  B.col(1) = t.cross(Eigen::Vector3d(B.col(0)));
  return B;
}

}  // namespace

EpipolarFit fit_epipolar(const Eigen::Matrix3d& R_to_from, std::span<const BearingPair> pairs,
                         const Eigen::Vector3d& direction, double focal_px,
                         double turn_sigma_rad) noexcept {
  EpipolarFit fit;
  fit.direction = direction.normalized();
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::Matrix3d R = so3::exp(fit.turn_rad).toRotationMatrix() * R_to_from;
    const Eigen::Matrix<double, 3, 2> B = tangents(fit.direction);
    const double belief = 1.0 / (turn_sigma_rad * turn_sigma_rad);
    Matrix5d H = 1e-6 * Matrix5d::Identity();
    Vector5d g = Vector5d::Zero();
    H.topLeftCorner<3, 3>().diagonal().array() += belief;
    g.head<3>() = -belief * fit.turn_rad;
    for (const BearingPair& pair : pairs) {
      const Eigen::Vector3d a = R * Eigen::Vector3d(pair.from_x, pair.from_y, 1.0);
      const Eigen::Vector3d b(pair.to_x, pair.to_y, 1.0);
      const Eigen::Vector3d line = fit.direction.cross(a);
      const double normal = line.head<2>().norm();
      if (!(normal > kLeastNormal)) continue;
      const double s = focal_px / normal;
      const double r = s * b.dot(line);
      // b . (t x (a + turn x a)) and b . ((t + B u) x a), the normal held.
      Vector5d J;
      J.head<3>() = s * a.cross(Eigen::Vector3d(b.cross(fit.direction)));
      J.tail<2>() = s * B.transpose() * a.cross(b);
      const double w = 1.0 / (1.0 + r * r / (kCauchy_px * kCauchy_px));
      H += w * J * J.transpose();
      g -= w * r * J;
    }
    const Vector5d d = H.ldlt().solve(g);
    if (!d.allFinite()) return fit;
    fit.turn_rad += d.head<3>();
    fit.direction = (fit.direction + B * d.tail<2>()).normalized();
  }
  return fit;
}

}  // namespace pled
