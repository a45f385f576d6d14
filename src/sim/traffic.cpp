#include "src/sim/traffic.hpp"

#include <numbers>
#include <utility>

namespace pled::sim {

void add_car(std::vector<Box>& boxes, double x_m, double y_m, double yaw_rad, Random& random,
             const DrivePath& drive) {
  const double length_m = random.uniform(3.9, 4.7);
  const double height_m = random.uniform(0.72, 0.85);
  constexpr double kClearance_m = 0.2;
  Box body = box_at({x_m, y_m, kClearance_m + 0.5 * height_m},
                    {0.5 * length_m, 0.9, 0.5 * height_m}, yaw_rad);
  body.finish = {Finish::kCarEnd,  Finish::kCarEnd, Finish::kCarSide,
                 Finish::kCarSide, Finish::kCarTop, Finish::kCarTop};
  body.texel_m = 0.01;
  body.drive = drive;
  const double back_m = 0.08 * length_m;  // the cabin sits behind the middle
  const Eigen::Vector3d centre =
      body.T_world_rest * Eigen::Vector3d{-back_m, 0.0, 0.5 * height_m + 0.27};
  Box cabin = box_at(centre, {0.26 * length_m, 0.78, 0.27}, yaw_rad);
  cabin.finish.fill(Finish::kGlass);
  cabin.finish[5] = Finish::kCarTop;
  cabin.texel_m = 0.01;
  cabin.drive = drive;
  boxes.push_back(std::move(body));
  boxes.push_back(std::move(cabin));
}

void add_van(std::vector<Box>& boxes, double x_m, double y_m, double yaw_rad, Random& random,
             const DrivePath& drive) {
  const double half_z = 0.5 * random.uniform(2.2, 2.7);
  constexpr double kClearance_m = 0.2;
  Box box = box_at({x_m, y_m, kClearance_m + half_z}, {0.5 * random.uniform(5.2, 6.2), 1.0, half_z},
                   yaw_rad);
  box.finish = {Finish::kCarEnd, Finish::kCarEnd, Finish::kCrate,
                Finish::kCrate,  Finish::kCarTop, Finish::kCarTop};
  box.texel_m = 0.01;
  box.drive = drive;
  boxes.push_back(std::move(box));
}

void add_person(std::vector<Box>& boxes, double x_m, double y_m, const Eigen::Vector2d& reach_m,
                double period_s, Random& random) {
  const Eigen::Vector3d half{0.16, 0.25, 0.5 * random.uniform(1.6, 1.85)};
  Box box = box_at({x_m, y_m, half.z() + 0.03}, half, random.uniform(-0.5, 0.5));
  box.walk.reach_m = {reach_m.x(), reach_m.y(), 0.0};
  box.walk.rate_radps = 2.0 * std::numbers::pi / period_s;
  box.walk.phase_rad = random.uniform(0.0, 2.0 * std::numbers::pi);
  box.walk.bob_m = 0.02;
  box.walk.turn_rad = 0.5;
  box.finish.fill(Finish::kCloth);
  boxes.push_back(std::move(box));
}

Box make_surroundings(const Eigen::Vector2d& centre_m, const Eigen::Vector3d& half_m) {
  Box box = box_at({centre_m.x(), centre_m.y(), half_m.z()}, half_m, 0.0);
  box.seen_from_inside = true;
  box.finish = {Finish::kSkyline, Finish::kSkyline, Finish::kSkyline,
                Finish::kSkyline, Finish::kAsphalt, Finish::kSky};
  box.texel_m = 0.12;
  return box;
}

}  // namespace pled::sim
