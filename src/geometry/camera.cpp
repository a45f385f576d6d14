#include "pled_vins/geometry/camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pled {
namespace {

constexpr int kMaxNewtonSteps = 20;
constexpr double kConverged = 1e-9;       // of the residual on the plane z = 1, as promised
constexpr double kFullPrecision = 1e-15;  // no further step can help
constexpr double kMinDepth = 1e-6;
// No lens model is used beyond this angle from the axis: the plane z = 1 ends at 90 deg.
constexpr double kMaxAngle_rad = 89.9 / 180.0 * std::numbers::pi;
constexpr int kTurningScan = 360;

/// d(r_d) / d(r) up to a positive factor: negative where the model folds back.
double radial_slope(const CameraCalibration& c, double angle_rad) noexcept {
  const auto& k = c.coeffs;
  if (c.distortion == Distortion::kRadtan) {
    const double r = std::tan(angle_rad);
    const double t = r * r;
    return 1.0 + t * (3.0 * k[0] + t * (5.0 * k[1] + t * 7.0 * k[4]));
  }
  const double t = angle_rad * angle_rad;
  return 1.0 + t * (3.0 * k[0] + t * (5.0 * k[1] + t * (7.0 * k[2] + t * 9.0 * k[3])));
}

/// The smallest |(x, y)| at which the model stops growing, or that of kMaxAngle_rad.
double find_turning_radius(const CameraCalibration& c) noexcept {
  if (c.distortion == Distortion::kNone) return std::tan(kMaxAngle_rad);
  double good = 0.0;
  double bad = 0.0;
  for (int i = 1; i <= kTurningScan && !(bad > 0.0); ++i) {
    const double angle = kMaxAngle_rad * i / kTurningScan;
    (radial_slope(c, angle) > 0.0 ? good : bad) = angle;
  }
  if (!(bad > 0.0)) return std::tan(kMaxAngle_rad);
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (good + bad);
    (radial_slope(c, middle) > 0.0 ? good : bad) = middle;
  }
  return std::tan(good);
}

/// Brown-Conrady on the plane z = 1, as OpenCV and Kalibr's radtan define it, with its Jacobian.
Eigen::Vector2d radtan(const std::array<double, 5>& k, const Eigen::Vector2d& p,
                       Eigen::Matrix2d& d) noexcept {
  const double x = p.x();
  const double y = p.y();
  const double p1 = k[2];
  const double p2 = k[3];
  const double t = x * x + y * y;
  const double radial = 1.0 + t * (k[0] + t * (k[1] + t * k[4]));
  const double d_radial_d_t = k[0] + t * (2.0 * k[1] + t * 3.0 * k[4]);
  d(0, 0) = radial + 2.0 * x * x * d_radial_d_t + 2.0 * p1 * y + 6.0 * p2 * x;
  d(0, 1) = 2.0 * x * y * d_radial_d_t + 2.0 * p1 * x + 2.0 * p2 * y;
  d(1, 0) = d(0, 1);
  d(1, 1) = radial + 2.0 * y * y * d_radial_d_t + 6.0 * p1 * y + 2.0 * p2 * x;
  return {x * radial + 2.0 * p1 * x * y + p2 * (t + 2.0 * x * x),
          y * radial + p1 * (t + 2.0 * y * y) + 2.0 * p2 * x * y};
}

/// theta_d of theta and its derivative; Kannala-Brandt as in Kalibr's equidistant.
double equidistant_angle(const std::array<double, 5>& k, double theta, double& slope) noexcept {
  const double t = theta * theta;
  slope = 1.0 + t * (3.0 * k[0] + t * (5.0 * k[1] + t * (7.0 * k[2] + t * 9.0 * k[3])));
  return theta * (1.0 + t * (k[0] + t * (k[1] + t * (k[2] + t * k[3]))));
}

Eigen::Vector2d equidistant(const std::array<double, 5>& k, const Eigen::Vector2d& p,
                            Eigen::Matrix2d& d) noexcept {
  const double t = p.squaredNorm();
  const double r = std::sqrt(t);
  double slope = 0.0;
  const double theta_d = equidistant_angle(k, std::atan(r), slope);
  // s = theta_d / r and (ds/dr) / r; both by series near the axis, where r^6 is below rounding.
  double s = 1.0 + t * (k[0] - 1.0 / 3.0);
  double ds_d_r_by_r = 2.0 * (k[0] - 1.0 / 3.0) + 4.0 * t * (0.2 - k[0] + k[1]);
  if (t > 1e-6) {
    s = theta_d / r;
    ds_d_r_by_r = (slope / (1.0 + t) - s) / t;
  } else {
    s += t * t * (0.2 - k[0] + k[1]);
  }
  d = s * Eigen::Matrix2d::Identity() + ds_d_r_by_r * p * p.transpose();
  return s * p;
}

}  // namespace

Camera::Camera(const CameraCalibration& calibration) noexcept
    : c_(calibration), turning_radius_(find_turning_radius(calibration)) {}

Eigen::Vector2d Camera::distort(const Eigen::Vector2d& bearing_xy) const noexcept {
  Eigen::Matrix2d unused;
  return distort(bearing_xy, unused);
}

Eigen::Vector2d Camera::distort(const Eigen::Vector2d& bearing_xy,
                                Eigen::Matrix2d& d_px_d_xy) const noexcept {
  Eigen::Vector2d m = bearing_xy;
  switch (c_.distortion) {
    case Distortion::kNone: d_px_d_xy.setIdentity(); break;
    case Distortion::kRadtan: m = radtan(c_.coeffs, bearing_xy, d_px_d_xy); break;
    case Distortion::kEquidistant: m = equidistant(c_.coeffs, bearing_xy, d_px_d_xy); break;
  }
  d_px_d_xy.row(0) *= c_.fx_px;
  d_px_d_xy.row(1) *= c_.fy_px;
  return {c_.fx_px * m.x() + c_.cx_px, c_.fy_px * m.y() + c_.cy_px};
}

std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& p_cam) const noexcept {
  if (!(p_cam.z() > kMinDepth)) return std::nullopt;
  const Eigen::Vector2d bearing_xy = p_cam.head<2>() / p_cam.z();
  if (!(bearing_xy.norm() < turning_radius_)) return std::nullopt;
  return distort(bearing_xy);
}

std::optional<Eigen::Vector2d> Camera::undistort(const Eigen::Vector2d& raw_px) const noexcept {
  const Eigen::Vector2d target((raw_px.x() - c_.cx_px) / c_.fx_px,
                               (raw_px.y() - c_.cy_px) / c_.fy_px);
  if (!target.allFinite()) return std::nullopt;
  switch (c_.distortion) {
    case Distortion::kNone: return target;
    case Distortion::kRadtan: return undistort_radtan(target);
    case Distortion::kEquidistant: return undistort_equidistant(target);
  }
  return std::nullopt;
}

std::optional<Eigen::Vector2d> Camera::undistort_radtan(
    const Eigen::Vector2d& target_xy) const noexcept {
  const double start_norm = target_xy.norm();
  Eigen::Vector2d x = target_xy;
  if (start_norm > 0.9 * turning_radius_) x *= 0.9 * turning_radius_ / start_norm;
  Eigen::Matrix2d d;
  Eigen::Vector2d error = target_xy - radtan(c_.coeffs, x, d);
  for (int i = 0; i < kMaxNewtonSteps && error.norm() > kFullPrecision; ++i) {
    const double determinant = d.determinant();
    if (!(determinant > 0.0)) return std::nullopt;
    Eigen::Vector2d step(d(1, 1) * error.x() - d(0, 1) * error.y(),
                         d(0, 0) * error.y() - d(1, 0) * error.x());
    step /= determinant;
    // Halved until it stays inside the turning radius and comes closer: beyond the radius Newton
    // would find the folded image of another bearing.
    bool closer = false;
    for (int halving = 0; halving < 8 && !closer; ++halving, step *= 0.5) {
      const Eigen::Vector2d next = x + step;
      if (!(next.norm() < turning_radius_)) continue;
      Eigen::Matrix2d d_next;
      const Eigen::Vector2d error_next = target_xy - radtan(c_.coeffs, next, d_next);
      closer = error_next.norm() < error.norm();
      if (!closer) continue;
      x = next;
      d = d_next;
      error = error_next;
    }
    if (!closer) break;
  }
  if (!(error.norm() < kConverged) || !(d.determinant() > 0.0)) return std::nullopt;
  return x;
}

std::optional<Eigen::Vector2d> Camera::undistort_equidistant(
    const Eigen::Vector2d& target_xy) const noexcept {
  const double theta_d = target_xy.norm();
  if (theta_d < 1e-12) return target_xy;
  const double max_theta = std::atan(turning_radius_);
  double theta = std::min(theta_d, 0.9 * max_theta);
  double slope = 0.0;
  double error = theta_d - equidistant_angle(c_.coeffs, theta, slope);
  for (int i = 0; i < kMaxNewtonSteps && std::abs(error) > kFullPrecision; ++i) {
    double step = error / slope;
    bool closer = false;
    for (int halving = 0; halving < 8 && !closer; ++halving, step *= 0.5) {
      const double next = theta + step;
      if (!(next > 0.0 && next < max_theta)) continue;
      double next_slope = 0.0;
      const double next_error = theta_d - equidistant_angle(c_.coeffs, next, next_slope);
      closer = std::abs(next_error) < std::abs(error);
      if (!closer) continue;
      theta = next;
      slope = next_slope;
      error = next_error;
    }
    if (!closer) break;
  }
  if (!(std::abs(error) < kConverged) || !(slope > 0.0)) return std::nullopt;
  return Eigen::Vector2d(target_xy * (std::tan(theta) / theta_d));
}

}  // namespace pled
