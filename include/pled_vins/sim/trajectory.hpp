#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

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
};

/// A flight through the middle of a room: each coordinate and each Euler angle is
/// a sum of sines. About 1 m/s and below 1 rad/s; the seed moves phases and sizes.
class RoomFlight final : public Trajectory {
 public:
  RoomFlight(std::uint64_t seed, StartKind start, double still_s, double scale = 1.0,
             double pace = 1.0) noexcept;
  [[nodiscard]] Kinematics at(double t_s) const noexcept override;

 private:
  static constexpr std::size_t kTerms = 3;
  struct Sine {
    double amplitude = 0.0;
    double rate_radps = 0.0;
    double phase_rad = 0.0;
  };
  /// offset + sum of sines, with two derivatives.
  struct Channel {
    double offset = 0.0;
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
};

}  // namespace pled::sim
