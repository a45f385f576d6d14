#include "src/sim/world.hpp"

#include <cmath>
#include <numbers>
#include <span>

#include "src/sim/painter.hpp"
#include "src/sim/parallel.hpp"
#include "src/sim/random.hpp"

namespace pled::sim {
namespace {

constexpr double kBobsPerWalk = 3.0;

Box box_at(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& half_m, double yaw_rad) {
  Box box;
  box.half_m = half_m;
  box.T_world_rest.p = centre_m;
  box.T_world_rest.q = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
  return box;
}

/// Standing on the floor: place x y, size, yaw; moved a little by the seed.
void add_furniture(std::vector<Box>& boxes, Random random) {
  struct Piece {
    double x, y, width, depth, height, yaw;
  };
  constexpr Piece kPieces[] = {{3.9, 2.2, 0.8, 1.2, 2.0, 0.0},  {3.7, -2.3, 1.0, 0.9, 0.8, 0.3},
                               {3.6, 0.4, 0.8, 1.5, 0.75, 0.0}, {2.6, 2.9, 0.7, 0.6, 1.1, -0.4},
                               {2.4, -3.0, 1.2, 0.6, 1.5, 0.1}, {-2.9, 2.6, 0.9, 0.9, 1.2, 0.5},
                               {-2.9, -2.4, 0.8, 1.3, 1.8, 0.2}};
  for (const Piece& p : kPieces) {
    const double yaw = p.yaw + random.uniform(-0.2, 0.2);
    const double x = p.x + random.uniform(-0.1, 0.1), y = p.y + random.uniform(-0.1, 0.1);
    const Eigen::Vector3d half{0.5 * p.width, 0.5 * p.depth, 0.5 * p.height};
    boxes.push_back(box_at({x, y, half.z()}, half, yaw));
  }
}

/// Walkers stay where the flight does not come: 1.7 m and more in front of the middle.
void add_walkers(std::vector<Box>& boxes, MovingLevel level, Random random) {
  struct Walker {
    double x, y, reach_x, reach_y, period_s;
  };
  constexpr Walker kWalkers[] = {
      {2.5, 0.0, 0.2, 1.9, 6.5}, {2.2, -0.8, 0.1, 1.6, 5.0}, {2.3, 0.9, 0.15, 1.7, 7.5}};
  const std::span<const Walker> all{kWalkers};
  const std::size_t count = level == MovingLevel::kNone ? 0 : level == MovingLevel::kLow ? 1 : 3;
  for (const Walker& w : all.first(count)) {
    const Eigen::Vector3d half{0.16, 0.26, 0.5 * random.uniform(1.6, 1.85)};
    Box box = box_at({w.x, w.y, half.z() + 0.03}, half, random.uniform(-0.5, 0.5));
    box.walk.reach_m = {w.reach_x, w.reach_y, 0.0};
    box.walk.rate_radps = 2.0 * std::numbers::pi / (w.period_s * random.uniform(0.9, 1.1));
    box.walk.phase_rad = random.uniform(0.0, 2.0 * std::numbers::pi);
    box.walk.bob_m = 0.02;
    box.walk.turn_rad = 0.5;
    boxes.push_back(std::move(box));
  }
}

void enlarge(Box& box, double scale) {
  box.T_world_rest.p *= scale;
  box.half_m *= scale;
  box.walk.reach_m *= scale;
  box.walk.bob_m *= scale;
}

void paint_face(Box& box, std::size_t face, double scale, std::uint64_t seed, std::uint64_t index) {
  const std::size_t axis = face / 2;
  const double width_m = 2.0 * box.half_m(axis == 0 ? 1 : 0);
  const double height_m = 2.0 * box.half_m(axis == 2 ? 1 : 2);
  box.faces[face] = Texture{width_m, height_m, scale * (box.seen_from_inside ? 0.008 : 0.004)};
  Finish finish = box.can_move() ? Finish::kCloth : Finish::kCrate;
  if (box.seen_from_inside)
    finish = axis != 2 ? Finish::kWall : face == 4 ? Finish::kFloor : Finish::kCeiling;
  paint(box.faces[face], finish, stream(seed, Stream::kTexture, index * 6 + face));
}

}  // namespace

Pose Box::T_world_box(double t_s) const noexcept {
  if (!can_move()) return T_world_rest;
  const double s = walk.rate_radps * t_s + walk.phase_rad;
  Pose pose = T_world_rest;
  pose.p += walk.reach_m * std::sin(s);
  pose.p.z() += walk.bob_m * std::sin(kBobsPerWalk * s);
  pose.q = pose.q * Eigen::AngleAxisd(walk.turn_rad * std::sin(s), Eigen::Vector3d::UnitZ());
  return pose;
}

double Box::speed_mps(double t_s) const noexcept {
  if (!can_move()) return 0.0;
  const double s = walk.rate_radps * t_s + walk.phase_rad;
  const double along = walk.reach_m.norm() * std::abs(std::cos(s));
  const double up = kBobsPerWalk * walk.bob_m * std::abs(std::cos(kBobsPerWalk * s));
  const double turn = walk.turn_rad * std::abs(std::cos(s)) * half_m.head<2>().norm();
  return walk.rate_radps * (along + up + turn);
}

World make_room(std::uint64_t seed, MovingLevel moving, double scale) {
  World world;
  Box room = box_at({0.4, 0.0, 1.5}, {4.0, 3.5, 1.5}, 0.0);
  room.seen_from_inside = true;
  world.boxes.push_back(std::move(room));
  add_furniture(world.boxes, stream(seed, Stream::kTexture));
  add_walkers(world.boxes, moving, stream(seed, Stream::kMovers));
  for (Box& box : world.boxes) enlarge(box, scale);
  parallel_for(6 * world.boxes.size(), [&](std::size_t i) {
    paint_face(world.boxes[i / 6], i % 6, scale, seed, 1 + i / 6);
  });
  return world;
}

}  // namespace pled::sim
