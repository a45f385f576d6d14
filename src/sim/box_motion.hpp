#pragma once

#include <Eigen/Core>

#include "pled_vins/geometry/pose.hpp"

namespace pled::sim {

/// To and fro on a straight line with a slight sway, as a walker turns round at both
/// ends. All zero: the box stands still.
struct WalkPath {
  Eigen::Vector3d reach_m = Eigen::Vector3d::Zero();  ///< from the middle to either end
  double rate_radps = 0.0;
  double phase_rad = 0.0;
  double bob_m = 0.0;     ///< up and down, three times a walk
  double turn_rad = 0.0;  ///< sways about the vertical by this much

  [[nodiscard]] bool moves() const noexcept { return rate_radps > 0.0; }
  [[nodiscard]] Pose displaced(const Pose& rest, double t_s) const noexcept;
  /// Speed at most, of a point `reach` m from the vertical axis.
  [[nodiscard]] double speed_mps(double t_s, double reach) const noexcept;
};

/// Straight on, as a car does: always at one speed, or driving and standing by turns. All boxes of
/// one car share it.
struct DrivePath {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit, world; zero: does not drive
  double speed_mps = 0.0;
  double offset_m = 0.0;  ///< already driven at time 0
  double wrap_m = 0.0;    ///< > 0: from +wrap/2 it goes on at -wrap/2, where nobody looks
  double drive_s = 0.0;   ///< > 0: drives so long, ramps included, ...
  double stand_s = 0.0;   ///< ... then stands so long
  double ramp_s = 1.5;    ///< from rest to full speed and back
  double phase_s = 0.0;   ///< into its turn at time 0

  [[nodiscard]] bool moves() const noexcept { return speed_mps > 0.0; }
  [[nodiscard]] Pose displaced(const Pose& rest, double t_s) const noexcept;
  [[nodiscard]] double speed_at(double t_s) const noexcept;  ///< m/s

 private:
  struct Turn {
    double whole;  ///< turns finished
    double into_s;
  };
  [[nodiscard]] Turn turn_at(double t_s) const noexcept;
  [[nodiscard]] double driven_m(double t_s) const noexcept;
};

}  // namespace pled::sim
