#include "pled_vins/frontend/motion_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "pled_vins/core/check.hpp"
#include "pled_vins/core/limits.hpp"

namespace pled {
namespace {

constexpr std::size_t kMinPairs = 8;
/// Draws for 99.9 % with 35 % of inliers: log(0.001) / log(1 - 0.35^2) = 53.
constexpr int kDraws = 64;
constexpr double kPureRotationPx = 1.0;
/// Ours: below this median nearer points than the median are allowed so many times its parallax.
constexpr double kNearShare = 3.0;

/// A rotated earlier bearing and the later one, on the plane z = 1.
struct Ray {
  Eigen::Vector3d a;
  Eigen::Vector3d b;
  double parallax = 0.0;  ///< |a - b| on the plane z = 1
};
using Rays = std::array<Ray, limits::kMaxPoints>;

/// Distance of b to the epipolar line t x a, on the plane z = 1; |a - b| when a lies at the
/// epipole.
[[nodiscard]] double epipolar_distance(const Ray& ray, const Eigen::Vector3d& t) noexcept {
  const Eigen::Vector3d line = t.cross(ray.a);
  const double length = line.head<2>().norm();
  if (!(length > 1e-9)) return ray.parallax;
  return std::abs(ray.b.dot(line)) / length;
}

/// Depths are positive for p_to = R p_from + t: l_b b = l_a a + t, crossed with b and with a.
[[nodiscard]] bool in_front(const Ray& ray, const Eigen::Vector3d& t) noexcept {
  const Eigen::Vector3d axb = ray.a.cross(ray.b);
  return -t.cross(ray.b).dot(axb) > 0.0 && -t.cross(ray.a).dot(axb) > 0.0;
}

/// Truncated sum of squared distances; smaller is better.
[[nodiscard]] double cost(std::span<const Ray> rays, const Eigen::Vector3d& t,
                          double gate) noexcept {
  double sum = 0.0;
  for (const Ray& ray : rays) {
    const double d = epipolar_distance(ray, t);
    sum += std::min(d * d, gate * gate);
  }
  return sum;
}

/// Direction that is nearest to orthogonal to all a x b of the inliers of `t`.
[[nodiscard]] Eigen::Vector3d refine(std::span<const Ray> rays, const Eigen::Vector3d& t,
                                     double gate) noexcept {
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  for (const Ray& ray : rays) {
    if (!(epipolar_distance(ray, t) < gate)) continue;
    const Eigen::Vector3d n = ray.a.cross(ray.b);
    const Eigen::Vector3d line = t.cross(ray.a);
    // b . (t x a) = t . (a x b), over the line's length, is the distance in the image.
    const double weight = 1.0 / std::max(line.head<2>().squaredNorm(), 1e-4);
    M += weight * n * n.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(M);
  const Eigen::Vector3d refined = solver.eigenvectors().col(0);
  if (!refined.allFinite()) return t;
  return refined.dot(t) < 0 ? Eigen::Vector3d(-refined) : refined;
}

/// The sign of `t` under which most points with parallax lie in front of both cameras.
void orient(std::span<const Ray> rays, double gate, Eigen::Vector3d& t) noexcept {
  int votes = 0;
  for (const Ray& ray : rays) {
    if (!(ray.parallax > gate) || !(epipolar_distance(ray, t) < gate)) continue;
    if (in_front(ray, t)) ++votes;
    if (in_front(ray, -t)) --votes;
  }
  if (votes < 0) t = -t;
}

[[nodiscard]] double median_parallax(std::span<const Ray> rays) noexcept {
  std::array<double, limits::kMaxPoints> values{};
  std::transform(rays.begin(), rays.end(), values.begin(),
                 [](const Ray& ray) { return ray.parallax; });
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(rays.size() / 2);
  std::nth_element(values.begin(), middle,
                   values.begin() + static_cast<std::ptrdiff_t>(rays.size()));
  return *middle;
}

/// The direction of translation with the smallest cost, oriented.
[[nodiscard]] Eigen::Vector3d best_direction(std::span<const Ray> rays, double gate,
                                             std::mt19937_64& random) noexcept {
  double best_cost = std::numeric_limits<double>::infinity();
  Eigen::Vector3d best = Eigen::Vector3d::UnitZ();
  for (int k = 0; k < kDraws; ++k) {
    const Ray& first = rays[static_cast<std::size_t>(random() % rays.size())];
    const Ray& second = rays[static_cast<std::size_t>(random() % rays.size())];
    const Eigen::Vector3d t = first.a.cross(first.b).cross(second.a.cross(second.b));
    const double length = t.norm();
    if (!(length > 1e-12)) continue;
    const double c = cost(rays, t / length, gate);
    if (c < best_cost) {
      best_cost = c;
      best = t / length;
    }
  }
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector3d refined = refine(rays, best, gate);
    if (cost(rays, refined, gate) < best_cost) best = refined;
  }
  orient(rays, gate, best);
  return best;
}

}  // namespace

MotionEstimate MotionCheck::judge(const Eigen::Matrix3d& R_to_from,
                                  std::span<const BearingPair> pairs,
                                  std::span<MotionVerdict> verdicts) noexcept {
  PLED_CHECK(pairs.size() == verdicts.size() && pairs.size() <= limits::kMaxPoints);
  std::fill(verdicts.begin(), verdicts.end(), MotionVerdict{});
  MotionEstimate estimate;
  if (pairs.empty()) return estimate;

  Rays storage;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const BearingPair& p = pairs[i];
    const Eigen::Vector3d rotated = R_to_from * Eigen::Vector3d(p.from_x, p.from_y, 1.0);
    Ray& ray = storage[i];
    ray.b = Eigen::Vector3d(p.to_x, p.to_y, 1.0);
    ray.a = rotated.z() > 1e-3 ? Eigen::Vector3d(rotated / rotated.z()) : rotated;
    ray.parallax = (ray.a - ray.b).norm();
  }
  const std::span<const Ray> rays(storage.data(), pairs.size());
  const double median = median_parallax(rays);
  estimate.median_parallax_px = median * focal_px_;
  if (pairs.size() < kMinPairs) return estimate;

  if (estimate.median_parallax_px < kPureRotationPx) {
    const double gate_px = std::max(gate_px_, kNearShare * estimate.median_parallax_px);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      verdicts[i].residual_px = rays[i].parallax * focal_px_;
      verdicts[i].inlier = verdicts[i].residual_px < gate_px;
    }
    return estimate;
  }

  const double gate = gate_px_ / focal_px_;
  const Eigen::Vector3d best = best_direction(rays, gate, random_);
  estimate.translating = true;
  estimate.direction = best;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    verdicts[i].residual_px = epipolar_distance(rays[i], best) * focal_px_;
    // A point that slides along its epipolar line the wrong way is no part of the scene either.
    if (rays[i].parallax > 2.0 * gate && !in_front(rays[i], best))
      verdicts[i].residual_px = std::max(verdicts[i].residual_px, rays[i].parallax * focal_px_);
    verdicts[i].inlier = verdicts[i].residual_px < gate_px_;
  }
  return estimate;
}

}  // namespace pled
