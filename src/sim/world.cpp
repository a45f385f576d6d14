#include "src/sim/world.hpp"

#include <utility>

#include "src/sim/parallel.hpp"
#include "src/sim/random.hpp"

namespace pled::sim {
namespace {

void paint_face(Box& box, std::size_t face, std::uint64_t seed, std::uint64_t index) {
  const std::size_t axis = face / 2;
  const double width_m = 2.0 * box.half_m(axis == 0 ? 1 : 0);
  const double height_m = 2.0 * box.half_m(axis == 2 ? 1 : 2);
  box.faces[face] = make_texture(box.finish[face], width_m, height_m, box.texel_m);
  paint(box.faces[face], box.finish[face], stream(seed, Stream::kTexture, index * 6 + face));
}

}  // namespace

double Box::speed_mps(double t_s) const noexcept {
  return walk.speed_mps(t_s, half_m.head<2>().norm()) + (drive.moves() ? drive.speed_at(t_s) : 0.0);
}

Box box_at(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& half_m, double yaw_rad) {
  Box box;
  box.half_m = half_m;
  box.T_world_rest.p = centre_m;
  box.T_world_rest.q = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
  return box;
}

void paint_boxes(World& world, std::uint64_t seed) {
  parallel_for(6 * world.boxes.size(),
               [&](std::size_t i) { paint_face(world.boxes[i / 6], i % 6, seed, 1 + i / 6); });
}

Light light_of(Daylight daylight) noexcept {
  switch (daylight) {
    case Daylight::kDay: break;
    case Daylight::kDim: return {0.15F, 0.0F};
    case Daylight::kNight: return {0.018F, 0.20F};
  }
  return {};
}

World lay_out(const SimulationOptions& options) {
  const auto make = [&] {
    switch (options.world) {
      case WorldKind::kCarPark: return make_car_park(options.seed, options.moving);
      case WorldKind::kStreet:
        return make_street(options.seed, options.moving, options.speed_mps,
                           options.speed_mps * options.duration_s);
      case WorldKind::kRoom: break;
    }
    return make_room(options.seed, options.moving, options.scale);
  };
  World world = make();
  world.light = light_of(options.daylight);
  if (options.surfaces == Surfaces::kPebbles)  // a box's outline is a straight edge, too
    std::erase_if(world.boxes,
                  [](const Box& box) { return !box.can_move() && !box.seen_from_inside; });
  for (Box& box : world.boxes) {
    if (options.surfaces == Surfaces::kPebbles) box.finish.fill(Finish::kPebbles);
    if (options.surfaces == Surfaces::kStripes) box.finish.fill(Finish::kStripes);
  }
  return world;
}

World make_world(const SimulationOptions& options) {
  World world = lay_out(options);
  paint_boxes(world, options.seed);
  return world;
}

}  // namespace pled::sim
