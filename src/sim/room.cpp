#include <numbers>
#include <span>
#include <utility>

#include "src/sim/random.hpp"
#include "src/sim/world.hpp"

namespace pled::sim {
namespace {

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
    Box box = box_at({x, y, half.z()}, half, yaw);
    box.finish.fill(Finish::kCrate);
    boxes.push_back(std::move(box));
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
  const auto count = static_cast<std::size_t>(level);
  for (const Walker& w : all.first(count)) {
    const Eigen::Vector3d half{0.16, 0.26, 0.5 * random.uniform(1.6, 1.85)};
    Box box = box_at({w.x, w.y, half.z() + 0.03}, half, random.uniform(-0.5, 0.5));
    box.walk.reach_m = {w.reach_x, w.reach_y, 0.0};
    box.walk.rate_radps = 2.0 * std::numbers::pi / (w.period_s * random.uniform(0.9, 1.1));
    box.walk.phase_rad = random.uniform(0.0, 2.0 * std::numbers::pi);
    box.walk.bob_m = 0.02;
    box.walk.turn_rad = 0.5;
    box.finish.fill(Finish::kCloth);
    boxes.push_back(std::move(box));
  }
}

void enlarge(Box& box, double scale) {
  box.T_world_rest.p *= scale;
  box.half_m *= scale;
  box.walk.reach_m *= scale;
  box.walk.bob_m *= scale;
  box.texel_m *= scale;
}

}  // namespace

World make_room(std::uint64_t seed, MovingLevel moving, double scale) {
  World world;
  Box room = box_at({0.4, 0.0, 1.5}, {4.0, 3.5, 1.5}, 0.0);
  room.seen_from_inside = true;
  room.finish = {Finish::kWall, Finish::kWall,  Finish::kWall,
                 Finish::kWall, Finish::kFloor, Finish::kCeiling};
  room.texel_m = 0.008;
  world.boxes.push_back(std::move(room));
  add_furniture(world.boxes, stream(seed, Stream::kTexture));
  add_walkers(world.boxes, moving, stream(seed, Stream::kMovers));
  for (Box& box : world.boxes) enlarge(box, scale);
  return world;
}

}  // namespace pled::sim
