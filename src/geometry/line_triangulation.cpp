#include "pled_vins/geometry/line_triangulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace pled {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr int kMaxSteps = 8;
constexpr double kStepDone = 1e-12;
constexpr double kMinLength_sigmas = 4.0;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// One view as the reference camera sees it: x_view = R x + t.
struct RelativeView {
  Matrix3d R;
  Vector3d t;
  std::array<Vector3d, 2> ends;  ///< (x, y, 1), seen
};
using RelativeViews = std::array<RelativeView, kMaxTriangulationViews>;

/// The line in the reference camera by its segment's ends. Moved by e_k along nu, across the
/// segment, they stand at p_k / rho_k, so up to a factor
///   n = p_1 cross p_2,   d = rho_1 p_2 - rho_2 p_1.
struct Ends {
  Vector3d p1, p2, nu;

  [[nodiscard]] PluckerLine line(const Vector4d& x) const noexcept {
    const Vector3d a = p1 + x[0] * nu;
    const Vector3d b = p2 + x[1] * nu;
    return {a.cross(b), x[2] * b - x[3] * a};
  }
};

/// The moment about a view's camera, in its axes.
Vector3d moment(const RelativeView& v, const PluckerLine& line) noexcept {
  const Vector3d d = v.R * line.d;
  return v.R * line.n + v.t.cross(d);
}

/// d(moment) by (e_1, e_2, rho_1, rho_2).
Eigen::Matrix<double, 3, 4> moment_jacobian(const RelativeView& v, const Ends& ends,
                                            const Vector4d& x) noexcept {
  const Vector3d a = v.R * (ends.p1 + x[0] * ends.nu);
  const Vector3d b = v.R * (ends.p2 + x[1] * ends.nu);
  const Vector3d nu = v.R * ends.nu;
  const Vector3d across = v.t.cross(nu);
  Eigen::Matrix<double, 3, 4> J;
  J << nu.cross(b) - x[3] * across, a.cross(nu) + x[2] * across, v.t.cross(b), -v.t.cross(a);
  return J;
}

/// Sum of squared distances; with H = J^T J and g = J^T r. Infinity when a view has no picture of
/// the line.
double cost_at(std::span<const RelativeView> views, const Ends& ends, const Vector4d& x,
               Matrix4d& H, Vector4d& g) noexcept {
  H.setZero();
  g.setZero();
  double cost = 0.0;
  const PluckerLine line = ends.line(x);
  for (const RelativeView& v : views) {
    const Vector3d n = moment(v, line);
    if (!project({n, Vector3d::Zero()})) return kInfinity;
    const double m = n.head<2>().norm();
    const Eigen::Matrix<double, 3, 4> d_n = moment_jacobian(v, ends, x);
    for (const Vector3d& end : v.ends) {
      const double r = end.dot(n) / m;
      Vector3d d_r = end / m;
      d_r.head<2>() -= n.head<2>() * (r / (m * m));
      const Vector4d J = d_n.transpose() * d_r;
      H += J * J.transpose();
      g += J * r;
      cost += r * r;
    }
  }
  return cost;
}

/// Gauss-Newton from x; returns the final cost and the H that belongs to it.
double refine(std::span<const RelativeView> views, const Ends& ends, Vector4d& x,
              Matrix4d& H) noexcept {
  Vector4d g;
  double cost = cost_at(views, ends, x, H, g);
  for (int i = 0; i < kMaxSteps && std::isfinite(cost); ++i) {
    const Eigen::LDLT<Matrix4d> ldlt(H);
    if (ldlt.info() != Eigen::Success || !ldlt.isPositive()) return kInfinity;
    const Vector4d step = ldlt.solve(-g);
    const Vector4d next = x + step;
    Matrix4d H_next;
    Vector4d g_next;
    const double cost_next = cost_at(views, ends, next, H_next, g_next);
    if (!(cost_next <= cost)) break;
    x = next;
    H = H_next;
    g = g_next;
    cost = cost_next;
    if (step.norm() < kStepDone) break;
  }
  return cost;
}

/// The inverse depths by linear least squares: every end seen lies in the plane of the line and
/// its camera, q . (R n + t cross R d) = 0.
Vector2d first_depths(std::span<const RelativeView> views, const Ends& ends) noexcept {
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
  Vector2d b = Vector2d::Zero();
  const Vector3d n = ends.p1.cross(ends.p2);
  for (const RelativeView& v : views) {
    const Vector3d n_view = v.R * n;
    const double m2 = n_view.squaredNorm();
    const Vector3d by_rho1 = v.t.cross(v.R * ends.p2);
    const Vector3d by_rho2 = -v.t.cross(v.R * ends.p1);
    for (const Vector3d& q : v.ends) {
      const Vector2d row(q.dot(by_rho1), q.dot(by_rho2));
      A += row * row.transpose() / m2;
      b -= row * q.dot(n_view) / m2;
    }
  }
  return A.ldlt().solve(b);
}

/// Whether some camera left the plane of the reference segment by more than the segment's noise
/// can feign. An error e_k of an end turns the plane's normal by as much: with the camera at
/// alpha p_1 + beta p_2 + offset, the offset errs by m sqrt(alpha^2 + beta^2) sigma.
bool leaves_plane(std::span<const RelativeView> views, const Ends& ends,
                  const LineTriangulationRules& rules) noexcept {
  const Vector3d N = ends.p1.cross(ends.p2).normalized();
  const double m = N.head<2>().norm();
  Eigen::Matrix<double, 3, 2> P;
  P << ends.p1, ends.p2;
  const Eigen::LDLT<Eigen::Matrix2d> gram(P.transpose() * P);
  bool leaves = false;
  for (const RelativeView& v : views) {
    const Vector3d centre = -(v.R.transpose() * v.t);
    const Vector2d in_plane = gram.solve(P.transpose() * centre);
    const double sigma = m * in_plane.norm() * rules.sigma_xy;
    const double offset = std::abs(N.dot(centre));
    leaves = leaves || (offset > 0.0 && offset > rules.min_baseline_sigmas * sigma);
  }
  return leaves;
}

/// Largest angle between two planes through the line, each with one camera.
double largest_plane_angle(std::span<const RelativeView> views, const PluckerLine& line) noexcept {
  std::array<Vector3d, kMaxTriangulationViews> normals;
  double largest = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const RelativeView& v = views[i];
    normals[i] = (v.R.transpose() * moment(v, line)).normalized();
    for (std::size_t j = 0; j < i; ++j) {
      largest = std::max(largest, normals[i].cross(normals[j]).norm());
    }
  }
  return std::asin(std::min(1.0, largest));
}

/// Whether each view has what it saw in front of it. The middle, not the ends: that of a line that
/// runs far away may be seen beyond the vanishing point by noise alone.
bool in_front(std::span<const RelativeView> views, const PluckerLine& line) noexcept {
  return std::all_of(views.begin(), views.end(), [&line](const RelativeView& v) {
    const Vector2d middle = 0.5 * (v.ends[0] + v.ends[1]).head<2>();
    return point_seen_at({moment(v, line), v.R * line.d}, middle).has_value();
  });
}

/// Uncertainty of the worse inverse depth, in parts of the nearer end's. Infinity when H is
/// singular.
double depth_uncertainty(const Matrix4d& H, const Vector4d& x, double sigma_xy) noexcept {
  const Eigen::LDLT<Matrix4d> ldlt(H);
  if (ldlt.info() != Eigen::Success || !ldlt.isPositive()) return kInfinity;
  const Matrix4d covariance = ldlt.solve(Matrix4d::Identity());
  const double worse = std::max(covariance(2, 2), covariance(3, 3));
  return sigma_xy * std::sqrt(worse) / std::max(x[2], x[3]);
}

bool valid(const LineTriangulationRules& r) noexcept {
  return r.sigma_xy > 0.0 && r.min_angle_rad > 0.0 && r.min_baseline_sigmas > 0.0 &&
         r.max_depth_sigma > 0.0;
}

std::size_t longest(std::span<const SegmentView> views) noexcept {
  std::size_t best = 0;
  double length = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double here = (views[i].end_xy - views[i].start_xy).norm();
    if (here > length) {
      length = here;
      best = i;
    }
  }
  return best;
}

}  // namespace

std::optional<TriangulatedLine> triangulate_line(std::span<const SegmentView> views,
                                                 const LineTriangulationRules& rules) noexcept {
  const std::size_t n = views.size();
  if (n < 2 || n > kMaxTriangulationViews || !valid(rules)) return std::nullopt;
  TriangulatedLine out;
  out.view = longest(views);
  const SegmentView& reference = views[out.view];
  const Vector2d along = reference.end_xy - reference.start_xy;
  if (!(along.norm() > kMinLength_sigmas * rules.sigma_xy)) return std::nullopt;
  const Ends ends{reference.start_xy.homogeneous(), reference.end_xy.homogeneous(),
                  Vector3d(-along.y(), along.x(), 0.0) / along.norm()};
  RelativeViews relative;
  for (std::size_t i = 0; i < n; ++i) {
    const Pose T = views[i].T_world_cam.inverse() * reference.T_world_cam;
    relative[i] = {T.R(), T.p, {views[i].start_xy.homogeneous(), views[i].end_xy.homogeneous()}};
    if (!relative[i].R.allFinite() || !T.p.allFinite()) return std::nullopt;
    if (!relative[i].ends[0].allFinite() || !relative[i].ends[1].allFinite()) return std::nullopt;
  }
  const std::span<const RelativeView> seen(relative.data(), n);
  if (!leaves_plane(seen, ends, rules)) return std::nullopt;

  Vector4d x = Vector4d::Zero();
  x.tail<2>() = first_depths(seen, ends);
  Matrix4d H;
  const double cost = refine(seen, ends, x, H);
  if (!std::isfinite(cost) || !(x[2] > 0.0) || !(x[3] > 0.0)) return std::nullopt;
  const PluckerLine line = ends.line(x);
  out.depth_sigma = depth_uncertainty(H, x, rules.sigma_xy);
  out.angle_rad = largest_plane_angle(seen, line);
  if (!(out.depth_sigma <= rules.max_depth_sigma)) return std::nullopt;
  if (!(out.angle_rad >= rules.min_angle_rad) || !in_front(seen, line)) return std::nullopt;

  const PluckerLine unit{line.n / line.d.norm(), line.d / line.d.norm()};
  out.line_world = reference.T_world_cam * unit;
  out.start_world = reference.T_world_cam * ((ends.p1 + x[0] * ends.nu) / x[2]);
  out.end_world = reference.T_world_cam * ((ends.p2 + x[1] * ends.nu) / x[3]);
  out.rms_error = std::sqrt(cost / static_cast<double>(2 * n));
  if (!out.line_world.n.allFinite() || !out.start_world.allFinite() || !out.end_world.allFinite()) {
    return std::nullopt;
  }
  return out;
}

}  // namespace pled
