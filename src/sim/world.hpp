#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "pled_vins/geometry/pose.hpp"
#include "pled_vins/sim/options.hpp"
#include "src/sim/texture.hpp"

namespace pled::sim {

/// To and fro on a straight line with a slight sway, as a walker turns round at both
/// ends. All zero: the box stands still.
struct WalkPath {
  Eigen::Vector3d reach_m = Eigen::Vector3d::Zero();  ///< from the middle to either end
  double rate_radps = 0.0;
  double phase_rad = 0.0;
  double bob_m = 0.0;     ///< up and down, three times a walk
  double turn_rad = 0.0;  ///< sways about the vertical by this much
};

/// A textured box. Faces 0 ... 5 are -x +x -y +y -z +z in its own axes; a face's
/// picture has its corner at the lowest of the two other coordinates, in order.
struct Box {
  Eigen::Vector3d half_m = Eigen::Vector3d::Ones();
  Pose T_world_rest;  ///< at rest, in the middle of its walk
  WalkPath walk;
  bool seen_from_inside = false;  ///< the room itself
  std::array<Texture, 6> faces;

  [[nodiscard]] Pose T_world_box(double t_s) const noexcept;
  /// Speed of its fastest corner at most, m/s.
  [[nodiscard]] double speed_mps(double t_s) const noexcept;
  [[nodiscard]] bool can_move() const noexcept { return walk.rate_radps > 0.0; }
};

/// What there is to see. Box 0 is the room and encloses everything.
struct World {
  std::vector<Box> boxes;
};

/// Faster than this counts as moving in the labels, m/s.
inline constexpr double kMovingSpeedMps = 0.02;

/// An 8 x 7 x 3 m room with posters and furniture along its walls, and boxes the
/// size of a person that walk between. Static parts depend on the seed alone, so
/// all levels of one seed share them.
[[nodiscard]] World make_room(std::uint64_t seed, MovingLevel moving, double scale = 1.0);

}  // namespace pled::sim
