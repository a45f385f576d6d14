#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "pled_vins/core/result.hpp"
#include "pled_vins/sim/trajectory.hpp"

namespace pled::sim {

/// A recorded path made smooth: uniform cubic B-splines through positions and, normalised,
/// quaternions, fitted by least squares. Velocity, acceleration and angular rate are the exact
/// derivatives of what at() gives, so the inertial readings belong to it. Before and after its span
/// it stands still at its end.
class SplineTrajectory final : public Trajectory {
 public:
  struct Sample {
    double t_s;
    Pose T_world_body;
  };
  /// Times strictly increasing; at least 8 samples. Time 0 is that of the first sample.
  explicit SplineTrajectory(const std::vector<Sample>& samples);
  [[nodiscard]] Kinematics at(double t_s) const noexcept override;
  [[nodiscard]] double longest_s() const noexcept override { return duration_s_; }

 private:
  static constexpr double kKnotStep_s = 0.08;
  using Row = Eigen::Matrix<double, 7, 1>;  ///< p, q as x y z w

  double duration_s_ = 0.0;
  std::vector<Row> knots_;
};

/// From a TUM file, `t tx ty tz qx qy qz qw` a line, moved so that its middle lies at (0, 0, 1.45):
/// in the middle of the room, at head height. kNotFound, kCorrupt (unreadable line, or time that
/// does not increase; the error's detail is the number of the line), kUnsupported (fewer than 8
/// poses), kTooLarge (over an hour).
[[nodiscard]] Result<std::unique_ptr<Trajectory>> read_spline_trajectory(
    const std::filesystem::path& file);

}  // namespace pled::sim
