#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/so3.hpp"

namespace pled::imu_step {

inline Eigen::Vector3d gyro(const ImuSample& s) noexcept {
  return Eigen::Map<const Eigen::Vector3d>(s.gyro_radps.data());
}

inline Eigen::Vector3d accel(const ImuSample& s) noexcept {
  return Eigen::Map<const Eigen::Vector3d>(s.accel_mps2.data());
}

/// Weights of the samples before, at the start of, at the end of and after a step.
struct Weights {
  double before = 0.0;
  double start = 0.0;
  double end = 0.0;
  double after = 0.0;
};

/// Weights that give the signal a fraction u in [0, 1] into a step: of the polynomial through the
/// two samples of the step and those neighbours that exist (not null) and whose distance is 0.5
/// to 2 times the step. Jittered stamps would otherwise turn noise into slope.
[[nodiscard]] Weights weights_at(double u, const ImuSample* before, const ImuSample& start,
                                 const ImuSample& end, const ImuSample* after) noexcept;

/// The weighted sum of what `read` (gyro, accel) takes from each sample.
template <typename Read>
[[nodiscard]] Eigen::Vector3d blend(const Weights& w, const ImuSample* before,
                                    const ImuSample& start, const ImuSample& end,
                                    const ImuSample* after, Read read) noexcept {
  Eigen::Vector3d v = w.start * read(start) + w.end * read(end);
  if (w.before != 0.0) v += w.before * read(*before);
  if (w.after != 0.0) v += w.after * read(*after);
  return v;
}

/// Rotation vector from the start of a step of h_s to its end, given the rate (rad/s) at start,
/// middle and end. 4th-order Magnus expansion for R' = R [w]x: Simpson's rule and the first
/// commutator; the sign of the latter belongs to body rates, which multiply on the right.
[[nodiscard]] inline Eigen::Vector3d full_rotation(const Eigen::Vector3d& w0,
                                                   const Eigen::Vector3d& wm,
                                                   const Eigen::Vector3d& w1, double h_s) noexcept {
  return h_s / 6.0 * (w0 + 4.0 * wm + w1) + h_s * h_s / 12.0 * w0.cross(w1);
}

/// The same from the start to the middle: the integral of the parabola over its first half.
[[nodiscard]] inline Eigen::Vector3d half_rotation(const Eigen::Vector3d& w0,
                                                   const Eigen::Vector3d& wm,
                                                   const Eigen::Vector3d& w1, double h_s) noexcept {
  return h_s / 24.0 * (5.0 * w0 + 8.0 * wm - w1) + h_s * h_s / 48.0 * w0.cross(wm);
}

}  // namespace pled::imu_step
