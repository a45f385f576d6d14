#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "pled_vins/reliability/entropy_recency.hpp"

/// How much of a line's fused weight is temporal, by the paper: section "Adaptive Fusion". Pixels
/// and directions are those of one picture, in which the camera's rotation is taken out of motion.
namespace pled {

/// Ours: motions shorter than this have a direction of noise only, and then half of the weight is
/// temporal.
inline constexpr double kLeastLineMotion_px = 0.5;
inline constexpr double kUnknownAlpha = 0.5;
/// Ours: epsilon of eqs. (16) and (17), in the units of what it stands beside, and the shortest
/// mean gradient (1/px) that has a direction.
inline constexpr double kMotionEpsilon_px = 0.1;
inline constexpr double kAlignmentEpsilon = 1e-3;
inline constexpr double kLeastGradient = 0.02;

/// Where a point is seen, and how far it went since the last sight.
struct PointMotion {
  Eigen::Vector2d at_px;
  Eigen::Vector2d by_px;
};

/// Ours: points within this of a line speak for its motion along itself, three of them or more.
inline constexpr double kPointsBeside_px = 30.0;
inline constexpr std::size_t kFewestPointsBeside = 3;
/// Ours: a segment that became longer or shorter by a larger part has lost an end.
inline constexpr double kSameLength = 0.1;

/// m of eqs. (16) and (17): how far a line went. Across itself by the mean distance of the present
/// ends from the earlier line. Along itself, where a line shows nothing, by the median of the
/// points beside it; with too few of them by the segment's middle, if both ends are real ones and
/// the length stayed the same; else 0.
/// @param real_ends  neither end is where the picture stops
[[nodiscard]] Eigen::Vector2d line_motion(const std::array<Eigen::Vector2d, 2>& then_px,
                                          const std::array<Eigen::Vector2d, 2>& now_px,
                                          bool real_ends,
                                          std::span<const PointMotion> points) noexcept;

/// Share of the motion that is across the line, in [0, 1]:
///   p_n = |m_n| / (|m_n| + |m_t| + epsilon)                                        eq. (16)
/// @param direction  of the line, any length but 0
[[nodiscard]] double normal_flow_ratio(const Eigen::Vector2d& motion,
                                       const Eigen::Vector2d& direction, double epsilon) noexcept;

/// How well the gradient of q points along the motion, whatever its sense, in [0, 1]:
///   r = |g . m| / (|g| |m| + epsilon)                                              eq. (17)
[[nodiscard]] double gradient_alignment(const Eigen::Vector2d& mean_gradient,
                                        const Eigen::Vector2d& motion, double epsilon) noexcept;

/// alpha_line = 1 - p_n (1 - r)                                                     eq. (15)
[[nodiscard]] constexpr double line_alpha(double p_n, double r) noexcept {
  return 1.0 - p_n * (1.0 - r);
}

/// All three.
///
///   kPaper  as printed, both epsilons kPaperEpsilon: of no motion p_n = 0, so alpha = 1.
///   kClean  with the constants above; r = 0 where the gradient is too short to point anywhere.
///
/// For a gradient across the line and motion at an angle to the normal, alpha is 1 at 0 and 90
/// degrees and at least 0.817 between.
/// @returns NaN when a value is not finite or the direction is 0.
[[nodiscard]] double line_alpha(const Eigen::Vector2d& motion_px, const Eigen::Vector2d& direction,
                                const Eigen::Vector2d& mean_gradient, ScoreForm form) noexcept;

}  // namespace pled
