#include "pled_vins/reliability/line_alpha.hpp"

#include <cmath>
#include <limits>

namespace pled {

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
