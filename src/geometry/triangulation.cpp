#include "pled_vins/geometry/triangulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace pled {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMaxSteps = 8;
constexpr double kMinDepth_m = 1e-3;
constexpr double kStepDone = 1e-12;

/// One view as the anchor sees it, so that h = R (a, b, 1) + rho t is parallel to the ray to the
/// point with bearing (a, b) and inverse depth rho in the anchor.
struct RelativeView {
  Matrix3d R;  ///< view from anchor
  Vector3d t;
  Vector2d seen;
};

using RelativeViews = std::array<RelativeView, kMaxTriangulationViews>;

/// Angle between unit vectors, accurate when small.
double angle_between(const Vector3d& a, const Vector3d& b) noexcept {
  return 2.0 * std::asin(std::min(1.0, 0.5 * (a - b).norm()));
}

/// Largest angle between two of the directions.
double largest_angle(std::span<const Vector3d> directions) noexcept {
  double largest = 0.0;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    for (std::size_t j = i + 1; j < directions.size(); ++j) {
      largest = std::max(largest, angle_between(directions[i], directions[j]));
    }
  }
  return largest;
}

/// Sum of squared distances; with H = J^T J and g = J^T r. Infinity when the point is not in
/// front of every view.
double cost_at(std::span<const RelativeView> views, const Vector3d& x, Matrix3d& H,
               Vector3d& g) noexcept {
  H.setZero();
  g.setZero();
  double cost = 0.0;
  for (const RelativeView& v : views) {
    const Vector3d h = v.R * Vector3d(x.x(), x.y(), 1.0) + x.z() * v.t;
    if (!(h.z() > kMinDepth_m * x.z())) return std::numeric_limits<double>::infinity();
    const double iz = 1.0 / h.z();
    const Vector2d predicted = h.head<2>() * iz;
    const Vector2d r = predicted - v.seen;
    Matrix3d d_h;
    d_h << v.R.col(0), v.R.col(1), v.t;
    const Eigen::Matrix<double, 2, 3> J = iz * (d_h.topRows<2>() - predicted * d_h.row(2));
    H += J.transpose() * J;
    g += J.transpose() * r;
    cost += r.squaredNorm();
  }
  return cost;
}

/// Gauss-Newton from x = (a, b, rho); returns the final cost.
double refine(std::span<const RelativeView> views, Vector3d& x) noexcept {
  Matrix3d H;
  Vector3d g;
  double cost = cost_at(views, x, H, g);
  for (int i = 0; i < kMaxSteps && std::isfinite(cost); ++i) {
    const Eigen::LDLT<Matrix3d> ldlt(H);
    if (ldlt.info() != Eigen::Success) break;
    const Vector3d step = ldlt.solve(-g);
    const Vector3d next = x + step;
    Matrix3d H_next;
    Vector3d g_next;
    const double cost_next = cost_at(views, next, H_next, g_next);
    if (!(cost_next <= cost)) break;
    x = next;
    H = H_next;
    g = g_next;
    cost = cost_next;
    if (step.norm() < kStepDone) break;
  }
  return cost;
}

/// The point with the least sum of squared distances to all rays: sum (I - d d^T) (p - c) = 0,
/// in the anchor's camera frame. nullopt when the rays are parallel.
std::optional<Vector3d> nearest_to_rays(std::span<const RelativeView> views) noexcept {
  Matrix3d A = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  for (const RelativeView& v : views) {
    const Vector3d d = v.R.transpose() * v.seen.homogeneous().normalized();
    const Vector3d c = -(v.R.transpose() * v.t);
    const Matrix3d across = Matrix3d::Identity() - d * d.transpose();
    A += across;
    b += across * c;
  }
  const Eigen::LDLT<Matrix3d> ldlt(A);
  if (ldlt.info() != Eigen::Success || !ldlt.isPositive()) return std::nullopt;
  const Vector3d p = ldlt.solve(b);
  if (!p.allFinite()) return std::nullopt;
  return p;
}

}  // namespace

std::optional<TriangulatedPoint> triangulate(std::span<const BearingView> views,
                                             std::size_t anchor) noexcept {
  const std::size_t n = views.size();
  if (n < 2 || n > kMaxTriangulationViews || anchor >= n) return std::nullopt;
  const Pose& T_world_anchor = views[anchor].T_world_cam;
  RelativeViews relative;
  std::array<Vector3d, kMaxTriangulationViews> rays;
  for (std::size_t i = 0; i < n; ++i) {
    const Pose T_cam_anchor = views[i].T_world_cam.inverse() * T_world_anchor;
    relative[i] = {T_cam_anchor.R(), T_cam_anchor.p, views[i].bearing_xy};
    rays[i] = relative[i].R.transpose() * relative[i].seen.homogeneous().normalized();
    if (!rays[i].allFinite() || !relative[i].t.allFinite()) return std::nullopt;
  }
  if (!(largest_angle({rays.data(), n}) > kMinTriangulationParallax_rad)) return std::nullopt;
  const std::span<const RelativeView> seen(relative.data(), n);
  const std::optional<Vector3d> start = nearest_to_rays(seen);
  if (!start || !(start->z() > kMinDepth_m)) return std::nullopt;
  Vector3d x(start->x() / start->z(), start->y() / start->z(), 1.0 / start->z());
  const double cost = refine(seen, x);
  if (!std::isfinite(cost) || !(x.z() > 0.0)) return std::nullopt;

  TriangulatedPoint out;
  const Vector3d p_anchor = Vector3d(x.x(), x.y(), 1.0) / x.z();
  for (std::size_t i = 0; i < n; ++i) {
    rays[i] = (p_anchor + relative[i].R.transpose() * relative[i].t).normalized();
  }
  out.p_world = T_world_anchor * p_anchor;
  out.inverse_depth = x.z();
  out.parallax_rad = largest_angle({rays.data(), n});
  out.rms_error = std::sqrt(cost / static_cast<double>(n));
  if (!(out.parallax_rad > kMinTriangulationParallax_rad) || !out.p_world.allFinite()) {
    return std::nullopt;
  }
  return out;
}

}  // namespace pled
