#include "src/reliability/line_depths.hpp"

#include <algorithm>
#include <cmath>

#include "src/reliability/cue_pool.hpp"

namespace pled::cue {
namespace {

constexpr double kRidge = 1e-12;
constexpr int kRoughSteps = 2;
/// Ours: inverse depths are spread by so much; a depth is free when as much is seen above noise.
constexpr double kSpread_pm = 0.5;

/// The least of x^T H x / 2 - g^T x for x_0, x_1 in [0, kMaxInverseDepth]; H is positive definite.
Eigen::Vector2d solve_in_bounds(const Eigen::Matrix2d& H, const Eigen::Vector2d& g) noexcept {
  const auto inside = [](double v) { return v >= 0.0 && v <= kMaxInverseDepth; };
  const double det = H(0, 0) * H(1, 1) - H(0, 1) * H(0, 1);
  if (det > 0.0) {
    const Eigen::Vector2d x((H(1, 1) * g[0] - H(0, 1) * g[1]) / det,
                            (H(0, 0) * g[1] - H(0, 1) * g[0]) / det);
    if (inside(x[0]) && inside(x[1])) return x;
  }
  Eigen::Vector2d best = Eigen::Vector2d::Zero();
  double least = 0.0;  // what it is at (0, 0)
  for (int held = 0; held < 2; ++held) {
    for (const double bound : {0.0, kMaxInverseDepth}) {
      const int other = 1 - held;
      Eigen::Vector2d x;
      x[held] = bound;
      x[other] = std::clamp((g[other] - H(0, 1) * bound) / H(other, other), 0.0, kMaxInverseDepth);
      const double value = 0.5 * x.dot(H * x) - g.dot(x);
      if (!(value < least)) continue;
      least = value;
      best = x;
    }
  }
  return best;
}

Eigen::Vector3d moment(const LineSight& s, const Eigen::Vector2d& rho) noexcept {
  return s.n + rho[0] * s.by_rho[0] + rho[1] * s.by_rho[1];
}

/// The problem near some depths: least of x^T H x / 2 - g^T x.
struct Equations {
  Eigen::Matrix2d H = kRidge * Eigen::Matrix2d::Identity();
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  /// Sums of the rows of either end: what an error of the ends seen now does to all sights.
  std::array<Eigen::Vector2d, 2> shared{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  double squares = 0.0;  ///< at these depths
};

/// @param exact  how |m_xy| changes is in the rows; else it is taken as it is, which leads near
///        the solution from anywhere
Equations equations_at(std::span<const LineSight> sights, const Eigen::Vector2d& rho,
                       bool exact) noexcept {
  Equations e;
  for (const LineSight& s : sights) {
    const Eigen::Vector3d m = moment(s, rho);
    const double length = std::max(m.head<2>().norm(), kLeastNormal);
    for (std::size_t k = 0; k < 2; ++k) {
      const double r = s.ends[k].dot(m) / length;
      Eigen::Vector2d row;
      for (int i = 0; i < 2; ++i) {
        const Eigen::Vector3d& by = s.by_rho[static_cast<std::size_t>(i)];
        const double longer = exact ? m.head<2>().dot(by.head<2>()) / length : 0.0;
        row[i] = (s.ends[k].dot(by) - r * longer) / length;
      }
      e.H += row * row.transpose();
      e.g += row * (row.dot(rho) - r);
      e.shared[k] += row;
      e.squares += r * r;
    }
  }
  return e;
}

/// Of the middle's inverse depth, for unit noise of every end, those seen now included.
double middle_sigma(const Equations& e) noexcept {
  const double det = e.H(0, 0) * e.H(1, 1) - e.H(0, 1) * e.H(0, 1);
  // H^-1 (1/2, 1/2)
  const Eigen::Vector2d h = 0.5 / std::max(det, kRidge * kRidge) *
                            Eigen::Vector2d(e.H(1, 1) - e.H(0, 1), e.H(0, 0) - e.H(0, 1));
  const double now = std::pow(h.dot(e.shared[0]), 2) + std::pow(h.dot(e.shared[1]), 2);
  return std::sqrt(h.dot(e.H * h) + now);
}

/// tr(H (H + l)^-1) with l the ratio of noise to spread: 2 where both depths matter, 0 where none.
double free_depths(const Eigen::Matrix2d& H, double noise) noexcept {
  const double l = noise * noise / (kSpread_pm * kSpread_pm);
  const double det = (H(0, 0) + l) * (H(1, 1) + l) - H(0, 1) * H(0, 1);
  return 2.0 - l * (H(0, 0) + H(1, 1) + 2.0 * l) / det;
}

}  // namespace

LineSight sight_of(const Pose& T_then_now, const std::array<Eigen::Vector3d, 2>& now,
                   const std::array<Eigen::Vector2d, 2>& then) noexcept {
  const Eigen::Vector3d a = T_then_now.q * now[0];
  const Eigen::Vector3d b = T_then_now.q * now[1];
  // Divided by the angle between the ends, so that lengths of m are those of its direction.
  const double scale = 1.0 / now[0].cross(now[1]).norm();
  return {scale * a.cross(b),
          {scale * T_then_now.p.cross(b), -scale * T_then_now.p.cross(a)},
          {then[0].homogeneous(), then[1].homogeneous()}};
}

DepthsFit best_depths(std::span<const LineSight> sights, double noise) noexcept {
  Eigen::Vector2d rho = Eigen::Vector2d::Zero();
  for (int step = 0; step < kRoughSteps; ++step) {
    const Equations rough = equations_at(sights, rho, false);
    rho = solve_in_bounds(rough.H, rough.g);
  }
  Equations best = equations_at(sights, rho, true);
  DepthsFit fit;
  fit.rho = rho;
  for (int step = 0; step < kFitSteps; ++step) {
    const Eigen::Vector2d next = solve_in_bounds(best.H, best.g);
    const Equations there = equations_at(sights, next, true);
    if (!(there.squares < best.squares)) break;
    best = there;
    fit.rho = next;
  }
  fit.squares = best.squares;
  fit.sigma = middle_sigma(best);
  fit.free_depths = free_depths(best.H, noise);
  return fit;
}

}  // namespace pled::cue
