#include "pled_vins/reliability/line_alpha.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pled_vins/core/limits.hpp"
#include "src/reliability/cue_pool.hpp"

namespace pled {
namespace {

/// Median of what points beside the segment went along it; NaN with too few.
double along_by_points(const std::array<Eigen::Vector2d, 2>& segment_px,
                       const Eigen::Vector2d& direction,
                       std::span<const PointMotion> points) noexcept {
  std::array<double, limits::kMaxPoints> along;
  std::size_t n = 0;
  for (const PointMotion& p : points.first(std::min(points.size(), along.size()))) {
    const double d2 = cue::squared_distance(p.at_px, segment_px[0], segment_px[1]);
    const double by = direction.dot(p.by_px);
    if (d2 <= kPointsBeside_px * kPointsBeside_px && std::isfinite(by)) along[n++] = by;
  }
  if (n < kFewestPointsBeside) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = along.begin() + static_cast<std::ptrdiff_t>(n / 2);
  std::nth_element(along.begin(), middle, along.begin() + static_cast<std::ptrdiff_t>(n));
  return *middle;
}

}  // namespace

Eigen::Vector2d line_motion(const std::array<Eigen::Vector2d, 2>& then_px,
                            const std::array<Eigen::Vector2d, 2>& now_px, bool real_ends,
                            std::span<const PointMotion> points) noexcept {
  const Eigen::Vector2d was = then_px[1] - then_px[0];
  const Eigen::Vector2d is = now_px[1] - now_px[0];
  const Eigen::Vector2d was_normal = Eigen::Vector2d(-was.y(), was.x()).normalized();
  const Eigen::Vector2d middle = 0.5 * (now_px[0] + now_px[1]);
  const double across = was_normal.dot(middle - then_px[0]);
  const Eigen::Vector2d direction = is.normalized();
  double along = along_by_points(now_px, direction, points);
  if (std::isnan(along)) {
    const bool same = std::abs(is.norm() - was.norm()) < kSameLength * was.norm();
    const Eigen::Vector2d went = middle - 0.5 * (then_px[0] + then_px[1]);
    along = real_ends && same ? direction.dot(went) : 0.0;
  }
  return across * Eigen::Vector2d(-direction.y(), direction.x()) + along * direction;
}

double normal_flow_ratio(const Eigen::Vector2d& motion, const Eigen::Vector2d& direction,
                         double epsilon) noexcept {
  const Eigen::Vector2d v = direction.normalized();
  const double along = std::abs(v.dot(motion));
  const double across = std::abs(v.x() * motion.y() - v.y() * motion.x());
  return across / (across + along + epsilon);
}

double gradient_alignment(const Eigen::Vector2d& mean_gradient, const Eigen::Vector2d& motion,
                          double epsilon) noexcept {
  return std::abs(mean_gradient.dot(motion)) / (mean_gradient.norm() * motion.norm() + epsilon);
}

double line_alpha(const Eigen::Vector2d& motion_px, const Eigen::Vector2d& direction,
                  const Eigen::Vector2d& mean_gradient, ScoreForm form) noexcept {
  if (!motion_px.allFinite() || !direction.allFinite() || !mean_gradient.allFinite() ||
      !(direction.norm() > 0.0))
    return std::numeric_limits<double>::quiet_NaN();
  if (form == ScoreForm::kPaper)
    return line_alpha(normal_flow_ratio(motion_px, direction, kPaperEpsilon),
                      gradient_alignment(mean_gradient, motion_px, kPaperEpsilon));
  if (!(motion_px.norm() >= kLeastLineMotion_px)) return kUnknownAlpha;
  const double r = mean_gradient.norm() >= kLeastGradient
                       ? gradient_alignment(mean_gradient, motion_px, kAlignmentEpsilon)
                       : 0.0;
  return line_alpha(normal_flow_ratio(motion_px, direction, kMotionEpsilon_px), r);
}

}  // namespace pled
