#pragma once

#include "pled_vins/backend/factors.hpp"
#include "pled_vins/backend/window.hpp"

namespace pled {

/// How exactly points and lines are tracked, measured from what the solves leave over. Ours: tracks
/// of a sharp picture are ten times as exact as those of a blurred or compressed one, and scale and
/// biases come out right only when vision and inertia are weighed as they deserve.
class FeatureNoise {
 public:
  /// `least_px`: of each kind, never below; what the estimate is at first.
  explicit FeatureNoise(const FeatureSigmas& least_px) noexcept
      : least_px_(least_px), measured_px_(least_px) {}

  /// After a solve, for each kind: follows the median over landmarks of the noise that their own
  /// residuals show (per degree of freedom, so few sightings do not look exact). A median, because
  /// points that move or are mistracked say nothing about the others.
  void observe(const SlidingWindow& window, const RigCalibration& rig,
               const FactorSettings& settings) noexcept;
  void reset() noexcept { measured_px_ = least_px_; }

  /// Standard deviation of one axis of each kind.
  [[nodiscard]] FeatureSigmas sigmas_px() const noexcept;

 private:
  void follow(FeatureKind kind, double now_px) noexcept;

  FeatureSigmas least_px_;
  FeatureSigmas measured_px_;
};

}  // namespace pled
