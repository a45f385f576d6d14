#pragma once

#include <array>
#include <optional>
#include <random>

#include <Eigen/Core>

#include "pled_vins/backend/start.hpp"
#include "src/backend/start/imu_path.hpp"
#include "src/backend/start/tracks.hpp"

namespace pled::start {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Minimises 1/2 x^T H x - b^T x over x = (v, g) with |g| = gravity: v eliminated, then the secular
/// equation (S + lambda I) g = r of the 3 x 3 rest. nullopt when H is degenerate.
[[nodiscard]] std::optional<Vector6d> solve_with_gravity(const Matrix6d& H, const Vector6d& b,
                                                         double gravity_mps2) noexcept;

/// Velocity at frame 0 and gravity (frame 0) from bearings by the closed form of Dong-Si and
/// Mourikis (IROS 2012), point by point eliminated, inside RANSAC over points.
class LinearSearch {
 public:
  /// x = (v_0, g), with the truncated reprojection cost of all tracks smallest; nullopt: none
  /// found.
  [[nodiscard]] std::optional<Vector6d> best(const Tracks& tracks, const ImuPath& path,
                                             const RigCalibration& rig,
                                             const BackendConfig& config) noexcept;

 private:
  /// A track's equations: 1/2 x^T H x - b^T x, metres squared; depth = a^T x + c.
  struct Equations {
    Matrix6d H;
    Vector6d b;
    Vector6d depth_a;
    double depth_c = 0;
    bool valid = false;
  };
  void prepare(std::size_t i, const Tracks& tracks, const ImuPath& path,
               const RigCalibration& rig) noexcept;
  /// From some tracks (`num` indices), reweighted by depth so that metres become pixels.
  [[nodiscard]] std::optional<Vector6d> solve(const std::size_t* chosen, std::size_t num,
                                              double gravity_mps2) const noexcept;
  /// Sum over tracks of min(mean squared error / gate^2, 1); marks those below 1.
  [[nodiscard]] double score(const Vector6d& x, const Tracks& tracks, const ImuPath& path,
                             const RigCalibration& rig, double gate) noexcept;

  std::array<Equations, kMaxTracks> equations_{};
  std::array<std::size_t, kMaxTracks> usable_{};
  std::size_t num_usable_ = 0;
  std::array<bool, kMaxTracks> agrees_{};
};

}  // namespace pled::start
