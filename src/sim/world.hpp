#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "pled_vins/geometry/pose.hpp"
#include "pled_vins/sim/options.hpp"
#include "src/sim/box_motion.hpp"
#include "src/sim/painter.hpp"
#include "src/sim/texture.hpp"

namespace pled::sim {

/// A textured box. Faces 0 ... 5 are -x +x -y +y -z +z in its own axes; a face's
/// picture has its corner at the lowest of the two other coordinates, in order.
struct Box {
  Eigen::Vector3d half_m = Eigen::Vector3d::Ones();
  Pose T_world_rest;  ///< at rest: in the middle of its walk, or where its drive begins
  WalkPath walk;
  DrivePath drive;
  bool seen_from_inside = false;  ///< what encloses everything
  std::array<Finish, 6> finish{};
  double texel_m = 0.004;
  std::array<Texture, 6> faces;

  [[nodiscard]] Pose T_world_box(double t_s) const noexcept {
    return drive.displaced(walk.displaced(T_world_rest, t_s), t_s);
  }
  /// Speed of its fastest corner at most, m/s.
  [[nodiscard]] double speed_mps(double t_s) const noexcept;
  [[nodiscard]] bool can_move() const noexcept { return walk.moves() || drive.moves(); }
};

/// Where the light comes from. Day: from everywhere.
struct Light {
  float ambient = 1.0F;    ///< on every surface
  float headlight = 0.0F;  ///< of a lamp at the camera, on a surface right before it
};

/// What there is to see. Box 0 encloses everything.
struct World {
  std::vector<Box> boxes;
  Light light;
};

/// Faster than this counts as moving in the labels, m/s.
inline constexpr double kMovingSpeedMps = 0.02;

/// What makes worlds leaves the pictures of their boxes empty: paint_boxes().
///
/// An 8 x 7 x 3 m room with posters and furniture along its walls, and boxes the
/// size of a person that walk between. Static parts depend on the seed alone, so
/// all levels of one seed share them.
[[nodiscard]] World make_room(std::uint64_t seed, MovingLevel moving, double scale = 1.0);

/// A car park of 70 x 50 m between houses: rows of parked cars on marked asphalt, lamp posts.
/// Cars cross, pass, start and stop, people walk, all more than 2 m from the flight.
[[nodiscard]] World make_car_park(std::uint64_t seed, MovingLevel moving);

/// A straight street between houses with parked cars, for a drive along +x at `ego_speed_mps` from
/// x = 0. Cars come the other way, cross, overtake, or drive ahead at the same speed and stop at
/// times; people walk on the pavement.
[[nodiscard]] World make_street(std::uint64_t seed, MovingLevel moving, double ego_speed_mps,
                                double length_m);

[[nodiscard]] Light light_of(Daylight daylight) noexcept;

/// The world that the options ask for, without pictures.
[[nodiscard]] World lay_out(const SimulationOptions& options);

/// The same, painted.
[[nodiscard]] World make_world(const SimulationOptions& options);

/// A box standing somewhere, not painted yet.
[[nodiscard]] Box box_at(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& half_m,
                         double yaw_rad);

/// Paints every face from streams of `seed`: box b has the stream of its place in the list, counted
/// from `first_stream`, so that what moves can be left out without changing the rest.
void paint_boxes(World& world, std::uint64_t seed);

}  // namespace pled::sim
