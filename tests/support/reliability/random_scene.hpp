#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include <Eigen/Core>

#include "pled_vins/geometry/pose.hpp"
#include "pled_vins/geometry/so3.hpp"
#include "support/reliability/watched_points.hpp"

namespace pled::support {

/// Off by more than this, a track is no thing at rest, whatever its depth.
inline constexpr double kClearlyMoves_px = 8.0;

/// What the laws of the motion cues draw: a flight, things before it, and noise of their sightings.
class RandomScene {
 public:
  explicit RandomScene(std::mt19937_64& random)
      : random_(random), turn_(0.03 * direction()), step_(0.04 * direction()) {}

  [[nodiscard]] double unit() { return unit_(random_); }  ///< in [-1, 1)
  [[nodiscard]] Eigen::Vector3d direction() {
    const double x = unit(), y = unit();
    return {x, y, unit()};
  }
  /// The camera after k frames: it turns and goes on steadily.
  [[nodiscard]] Pose pose(int k) const { return {so3::exp(k * turn_), k * step_}; }

  /// exp(1.6 -+ spread), m: 5 m, a few times less or more.
  [[nodiscard]] double depth_m(double spread) { return std::exp(1.6 + spread * unit()); }
  /// In view of the first pose.
  [[nodiscard]] Eigen::Vector3d place(double depth_m) {
    const double x = 0.4 * unit();
    return depth_m * Eigen::Vector3d(x, 0.3 * unit(), 1.0);
  }
  /// Across the view, up to 2 px a frame along each axis.
  [[nodiscard]] Eigen::Vector3d speed(double depth_m) {
    const double x = unit();
    return 0.01 * depth_m * Eigen::Vector3d(x, unit(), 0.0);
  }
  /// Of 0.2 px an axis, on the plane z = 1.
  [[nodiscard]] Eigen::Vector2d noise() {
    const double x = noise_(random_);
    return {x, noise_(random_)};
  }

 private:
  std::mt19937_64& random_;
  std::uniform_real_distribution<double> unit_{-1.0, 1.0};
  std::normal_distribution<double> noise_{0.0, 0.2 / kFocal_px};
  Eigen::Vector3d turn_, step_;  ///< a frame, rad and m
};

}  // namespace pled::support
