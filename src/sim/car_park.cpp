#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "src/sim/traffic.hpp"

namespace pled::sim {
namespace {

constexpr double kQuarter = 0.5 * std::numbers::pi;

void add_houses(std::vector<Box>& boxes, Random& random) {
  struct House {
    double x, y, half_x, half_y, height;
  };
  constexpr House kHouses[] = {{32.0, 8.0, 4.0, 9.0, 11.0},  {33.0, -12.0, 4.0, 8.0, 8.0},
                               {8.0, 22.0, 14.0, 4.0, 9.0},  {10.0, -23.0, 13.0, 4.0, 12.0},
                               {-18.0, 20.0, 8.0, 4.0, 7.0}, {-24.0, -4.0, 4.0, 12.0, 10.0}};
  for (const House& h : kHouses) {
    const double half_z = 0.5 * h.height * random.uniform(0.85, 1.15);
    Box box =
        box_at({h.x + random.uniform(-1.0, 1.0), h.y, half_z}, {h.half_x, h.half_y, half_z}, 0.0);
    box.finish.fill(Finish::kFacade);
    box.texel_m = 0.03;
    boxes.push_back(std::move(box));
  }
}

void add_posts(std::vector<Box>& boxes, Random& random) {
  for (const double x : {4.3, 18.0})
    for (const double y : {-6.8, 6.8}) {
      Box post = box_at({x + random.uniform(-0.5, 0.5), y, 2.5}, {0.09, 0.09, 2.5}, 0.3);
      post.finish.fill(Finish::kCrate);
      boxes.push_back(std::move(post));
    }
}

/// Lanes across the car park; the rows of parked cars have a gap there.
constexpr double kNearLane_m = 7.5;
constexpr double kMiddleLane_m = 10.5;
constexpr double kFarLane_m = 13.5;
constexpr double kLaneHalf_m = 2.3;
/// Lanes along it, between the posts and the way of the flight.
constexpr double kSideLane_m = 5.2;

/// Two rows to either side of the aisle, with gaps.
void add_parked(std::vector<Box>& boxes, Random& random) {
  for (const double y : {-9.6, 9.6}) {
    int left = 7;
    for (double x = -6.0; x < 26.0 && left > 0; x += 2.7) {
      const bool in_lane = x > kNearLane_m - kLaneHalf_m && x < kFarLane_m + kLaneHalf_m;
      if (random.uniform() < 0.2 || in_lane) continue;
      --left;
      add_car(boxes, x + random.uniform(-0.15, 0.15), y + random.uniform(-0.4, 0.4),
              (y > 0 ? -kQuarter : kQuarter) + random.uniform(-0.05, 0.05), random);
    }
  }
}

/// A drive over `wrap_m` and from its end to its beginning: both lie inside houses.
DrivePath drive(double yaw_rad, double speed_mps, double wrap_m) {
  DrivePath path;
  path.direction = {std::cos(yaw_rad), std::sin(yaw_rad), 0.0};
  path.speed_mps = speed_mps;
  path.wrap_m = wrap_m;
  return path;
}

/// `count` cars one behind the other, evenly over the lane. They keep their distance, be it that
/// all stop and start together; cars of other lanes they do not mind. With `vans` every second is a
/// van.
void add_lane(std::vector<Box>& boxes, double x_m, double y_m, double yaw_rad, DrivePath path,
              int count, Random& random, bool vans = false) {
  const double first_m = random.uniform(0.0, path.wrap_m);
  path.phase_s = random.uniform(0.0, std::max(1.0, path.drive_s + path.stand_s));
  for (int k = 0; k < count; ++k) {
    path.offset_m = first_m + k * path.wrap_m / count;
    if (vans && k % 2 == 1)
      add_van(boxes, x_m, y_m, yaw_rad, random, path);
    else
      add_car(boxes, x_m, y_m, yaw_rad, random, path);
  }
}

DrivePath with_stops(DrivePath path, double drive_s, double stand_s) {
  path.drive_s = drive_s;
  path.stand_s = stand_s;
  return path;
}

/// In order of the levels: what `low` has, `mid` and `high` have too.
void add_traffic(std::vector<Box>& boxes, MovingLevel level, Random random) {
  constexpr double kBack = std::numbers::pi;
  constexpr double kAcross_m = 44.0;  // from house to house
  constexpr double kAlong_m = 52.0;
  if (level >= MovingLevel::kLow) {
    add_lane(boxes, kFarLane_m, 0.0, kQuarter, drive(kQuarter, 3.0, kAcross_m), 1, random);
    add_person(boxes, 9.0, 2.0, {0.4, 2.5}, 11.0, random);
  }
  if (level >= MovingLevel::kMid) {
    add_lane(boxes, 6.0, kSideLane_m, kBack,  // comes towards, stops and starts
             with_stops(drive(kBack, 3.5, kAlong_m), 7.0, 3.0), 1, random);
    add_lane(boxes, kMiddleLane_m, 0.0, -kQuarter, drive(-kQuarter, 3.4, kAcross_m), 2, random);
    add_person(boxes, 5.9, -3.0, {0.2, 1.0}, 9.0, random);
  }
  if (level >= MovingLevel::kHigh) {
    add_lane(boxes, 6.0, -kSideLane_m, 0.0, drive(0.0, 2.2, kAlong_m), 1, random);  // alongside
    add_lane(boxes, kNearLane_m, 0.0, kQuarter,  // close by, stops and starts
             with_stops(drive(kQuarter, 2.6, kAcross_m), 5.0, 2.0), 4, random, true);
    add_person(boxes, 5.9, 0.5, {0.2, 2.0}, 12.0, random);
  }
}

}  // namespace

World make_car_park(std::uint64_t seed, MovingLevel moving) {
  World world;
  Random random = stream(seed, Stream::kTexture);
  world.boxes.push_back(make_surroundings({5.0, 0.0}, {60.0, 50.0, 20.0}));
  add_houses(world.boxes, random);
  add_posts(world.boxes, random);
  add_parked(world.boxes, random);
  add_traffic(world.boxes, moving, stream(seed, Stream::kMovers));
  return world;
}

}  // namespace pled::sim
