#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/pose.hpp"

/// What the cues of points and of lines have in common while neighbours are pooled.
namespace pled::cue {

inline constexpr double kLeastZ = 1e-3;
inline constexpr double kNearest_m = 0.2;
inline constexpr double kMaxInverseDepth = 1.0 / kNearest_m;
inline constexpr int kFitSteps = 4;
inline constexpr double kLeastResidual_px = 0.05;
inline constexpr double kMostResidual_px = 20.0;
/// Neighbours whose weights add up to less say nothing.
inline constexpr double kLeastWeight = 0.02;
/// A share of doubt that keeps one distant neighbour from being believed as much as many near ones.
inline constexpr double kDoubt = 0.05;
/// Noise of a sight as a share of the residual at which a feature is as likely to move as to rest.
inline constexpr double kNoiseOfEven = 0.5;
/// What stands nearer than its surroundings moves by itself more often than they do; so much a
/// factor e of nearness counts, against a factor e of residual. Surroundings: a Gaussian on the
/// plane z = 1; nearness is told apart up to the floor's distance, and no more than the limit.
inline constexpr double kNearnessWeight = 1.0;
inline constexpr double kNearnessRadius = 0.25;
inline constexpr double kNearnessFloor_pm = 0.1;
inline constexpr double kMostNearness = 1.5;
/// A depth that is known to this (relative to it plus the floor) tells half of what a sure one
/// does; one that is known to the second in metres is a depth to reckon with.
inline constexpr double kHalfSure = 0.3;
inline constexpr double kWellKnown = 1.0 / 3.0;

/// Belief from a residual, px: above 0 moves by itself.
[[nodiscard]] inline double belief_of(double residual_px, double even_px) noexcept {
  return std::log(std::clamp(residual_px, kLeastResidual_px, kMostResidual_px) / even_px);
}

/// w_static from a pooled belief.
[[nodiscard]] inline double rest_of(double belief, double steepness) noexcept {
  return 1.0 / (1.0 + std::exp(steepness * belief));
}

/// exp(-d^2 / 2 radius^2).
[[nodiscard]] inline double closeness(double squared_distance, double radius) noexcept {
  return std::exp(-(0.5 / (radius * radius)) * squared_distance);
}

/// How near something is, as a logarithm, and how sure that is, in [0, 1].
struct Nearness {
  double log_rho = 0.0;
  double sure = 0.0;
};

[[nodiscard]] inline Nearness nearness_of(double inverse_depth_pm, double sigma_pm) noexcept {
  const double rho = inverse_depth_pm + kNearnessFloor_pm;
  const double open = sigma_pm / (kHalfSure * rho);
  return {std::log(rho), 1.0 / (1.0 + open * open)};
}

/// What nearness adds to a belief; `surroundings` is their weighted mean.
[[nodiscard]] inline double doubt_of_near(const Nearness& own, double surroundings) noexcept {
  return kNearnessWeight * own.sure *
         std::clamp(own.log_rho - surroundings, -kMostNearness, kMostNearness);
}

/// Where another camera (the frame camera) has what one sees, on its plane z = 1.
/// @param inverse_depth_pm  0: as if it were infinitely far
[[nodiscard]] inline Eigen::Vector2d place_of(const Pose& T_other_cam,
                                              const std::array<double, 2>& bearing_xy,
                                              double inverse_depth_pm) noexcept {
  const Eigen::Vector3d q = T_other_cam.q * Eigen::Vector3d(bearing_xy[0], bearing_xy[1], 1.0) +
                            inverse_depth_pm * T_other_cam.p;
  return q.head<2>() / std::max(q.z(), kLeastZ);
}

/// Squared distance of a point to the segment from `a` to `b`.
[[nodiscard]] inline double squared_distance(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                                             const Eigen::Vector2d& b) noexcept {
  const Eigen::Vector2d along = b - a;
  const double length2 = along.squaredNorm();
  const double s = length2 > 0.0 ? std::clamp(along.dot(p - a) / length2, 0.0, 1.0) : 0.0;
  return (p - a - s * along).squaredNorm();
}

/// The index of a feature of an earlier frame. Tracks keep their order, so it stands at its last
/// place, the hint, or before it; looked for from there on first.
[[nodiscard]] inline std::optional<std::size_t> find(std::span<const FeatureId> ids, FeatureId id,
                                                     std::size_t hint) noexcept {
  for (std::size_t i = std::min(hint, ids.size()); i < ids.size(); ++i)
    if (ids[i] == id) return i;
  for (std::size_t i = 0; i < std::min(hint, ids.size()); ++i)
    if (ids[i] == id) return i;
  return std::nullopt;
}

}  // namespace pled::cue
