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
  for (const double x : {6.0, 19.0})
    for (const double y : {-6.8, 6.8}) {
      Box post = box_at({x + random.uniform(-0.5, 0.5), y, 2.5}, {0.09, 0.09, 2.5}, 0.3);
      post.finish.fill(Finish::kCrate);
      boxes.push_back(std::move(post));
    }
}

/// Two rows to either side of the aisle, with gaps.
void add_parked(std::vector<Box>& boxes, Random& random) {
  for (const double y : {-9.6, 9.6}) {
    int left = 7;
    for (double x = -4.0; x < 24.0 && left > 0; x += 2.9) {
      if (random.uniform() < 0.3) continue;
      --left;
      add_car(boxes, x + random.uniform(-0.15, 0.15), y + random.uniform(-0.4, 0.4),
              (y > 0 ? -kQuarter : kQuarter) + random.uniform(-0.05, 0.05), random);
    }
  }
}

/// In order of the levels: what `low` has, `mid` and `high` have too.
void add_traffic(std::vector<Box>& boxes, MovingLevel level, Random random) {
  const auto drive = [&](double yaw_rad, double speed_mps, double drive_s, double stand_s) {
    DrivePath path;
    path.direction = {std::cos(yaw_rad), std::sin(yaw_rad), 0.0};
    path.speed_mps = speed_mps * random.uniform(0.9, 1.1);
    path.wrap_m = 44.0;
    path.offset_m = random.uniform(-8.0, 8.0);
    path.drive_s = drive_s;
    path.stand_s = stand_s;
    path.phase_s = random.uniform(0.0, drive_s + stand_s);
    return path;
  };
  const auto car = [&](double x, double y, double yaw, double speed, double drives, double stands) {
    add_car(boxes, x, y, yaw, random, drive(yaw, speed, drives, stands));
  };
  constexpr double kBack = std::numbers::pi;
  if (level >= MovingLevel::kLow) {
    car(13.0, 0.0, kQuarter, 3.0, 0.0, 0.0);  // crosses
    add_person(boxes, 9.5, 2.0, {0.6, 2.5}, 11.0, random);
  }
  if (level >= MovingLevel::kMid) {
    car(6.0, 6.2, kBack, 3.5, 7.0, 3.0);  // comes towards, stops and starts
    add_person(boxes, 8.0, -3.0, {1.5, 1.0}, 9.0, random);
  }
  if (level >= MovingLevel::kHigh) {
    car(8.0, -6.0, 0.0, 2.2, 0.0, 0.0);        // goes alongside
    car(16.5, 0.0, -kQuarter, 3.6, 6.0, 2.0);  // crosses the other way
    car(10.2, 0.0, kQuarter, 2.4, 5.0, 4.0);   // crosses near by, stops and starts
    add_person(boxes, 7.5, 0.5, {0.3, 3.0}, 12.0, random);
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
