#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <memory>

#include <Eigen/Core>

#include "pled_vins/core/result.hpp"
#include "pled_vins/geometry/pose.hpp"
#include "pled_vins/sim/options.hpp"

namespace pled::sim {

/// The body at an instant, exact to rounding.
struct Kinematics {
  Pose T_world_body;                                        ///< world z up
  Eigen::Vector3d v_wb_mps = Eigen::Vector3d::Zero();       ///< of the body, in world
  Eigen::Vector3d a_wb_mps2 = Eigen::Vector3d::Zero();      ///< in world, gravity not included
  Eigen::Vector3d omega_b_radps = Eigen::Vector3d::Zero();  ///< of the body, in body
};

/// A smooth motion with exact derivatives. Any time may be asked for, in any order,
/// from any thread.
class Trajectory {
 public:
  virtual ~Trajectory() = default;
  [[nodiscard]] virtual Kinematics at(double t_s) const noexcept = 0;
  /// It is a motion from 0 to this, s; beyond, at() stands where it ended, from one instant to the
  /// next.
  [[nodiscard]] virtual double longest_s() const noexcept {
    return std::numeric_limits<double>::infinity();
  }
};

/// Coordinates and Euler angles as sums of sines, about a place and along a drift; the seed moves
/// phases and sizes.
///   room, drone      a flight through the middle, about 1 m/s and below 1 rad/s
///   hand             the same path shorter, with turns up to 4 rad/s
///   car park, drone  wider, about 1.5 m/s, at head height
///   car              along +x at a speed, heading along the path
class SineFlight final : public Trajectory {
 public:
  /// Uses world, motion, start, still_s, speed_mps, scale, pace and seed.
  explicit SineFlight(const SimulationOptions& options) noexcept;
  [[nodiscard]] Kinematics at(double t_s) const noexcept override;

 private:
  static constexpr std::size_t kTerms = 3;
  struct Sine {
    double amplitude = 0.0;
    double rate_radps = 0.0;
    double phase_rad = 0.0;
  };
  /// offset + drift s + sum of sines, with two derivatives.
  struct Channel {
    double offset = 0.0;
    double drift = 0.0;
    std::array<Sine, kTerms> terms{};
    [[nodiscard]] Eigen::Vector3d at(double s) const noexcept;  ///< value, d/ds, d2/ds2
  };
  struct Warp {
    double s, ds, dds;
  };
  /// The flight's own time s(t): it stands still, then starts gently.
  [[nodiscard]] Warp warp(double t_s) const noexcept;

  std::array<Channel, 3> position_{};  ///< x y z, m
  std::array<Channel, 3> angles_{};    ///< roll pitch yaw, rad
  double still_s_ = 0.0;
  bool starts_still_ = false;
  bool stands_ = false;
  bool heads_along_path_ = false;
};

/// What the options ask for: a made flight, or the path in their file. kNotFound, kCorrupt or
/// kUnsupported (fewer than 8 poses) when the file is no good.
[[nodiscard]] Result<std::unique_ptr<Trajectory>> make_trajectory(const SimulationOptions& options);

}  // namespace pled::sim
