#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "src/sim/traffic.hpp"

namespace pled::sim {
namespace {

constexpr double kBehind_m = 15.0;  // houses begin
constexpr double kAhead_m = 70.0;   // and go on beyond the end of the drive
constexpr std::size_t kHousesPerSide = 8;
constexpr std::size_t kParked = 12;

/// A side street, in which a car crosses: nothing stands there.
double side_street_m(double length_m) { return 0.45 * length_m + 8.0; }
constexpr double kSideStreetHalf_m = 5.0;

void add_houses(std::vector<Box>& boxes, double length_m, Random& random) {
  const double each_m = (kBehind_m + length_m + kAhead_m) / static_cast<double>(kHousesPerSide);
  for (const double side : {-1.0, 1.0})
    for (std::size_t k = 0; k < kHousesPerSide; ++k) {
      const double half_x = 0.5 * each_m - random.uniform(0.3, 1.2);
      const double half_z = 0.5 * random.uniform(7.0, 14.0);
      double x = -kBehind_m + (static_cast<double>(k) + 0.5) * each_m;
      const double away_m = x - side_street_m(length_m);
      const double least_m = half_x + kSideStreetHalf_m;
      // A house at the corner is cut back to it.
      double half = half_x;
      if (std::abs(away_m) < least_m) {
        half = std::max(1.0, half_x - 0.5 * (least_m - std::abs(away_m)));
        x = side_street_m(length_m) + std::copysign(half + kSideStreetHalf_m, away_m);
      }
      const double y = side * (10.0 + random.uniform(-0.6, 0.6) + 4.0);
      Box box = box_at({x, y, half_z}, {half, 4.0, half_z}, 0.0);
      box.finish.fill(Finish::kFacade);
      box.texel_m = std::clamp(each_m / 800.0, 0.03, 0.08);
      boxes.push_back(std::move(box));
    }
}

void add_kerbs(std::vector<Box>& boxes, double length_m) {
  const double half_x = 0.5 * (kBehind_m + length_m + kAhead_m);
  for (const double side : {-1.0, 1.0}) {
    Box kerb = box_at({half_x - kBehind_m, side * 8.6, 0.07}, {half_x, 1.5, 0.07}, 0.0);
    kerb.finish.fill(Finish::kPavement);
    kerb.texel_m = 0.05;
    boxes.push_back(std::move(kerb));
  }
}

void add_parked(std::vector<Box>& boxes, double length_m, Random& random) {
  const double each_m = (length_m + 30.0) / (0.5 * static_cast<double>(kParked));
  for (std::size_t k = 0; k < kParked; ++k) {
    const double side = k % 2 == 0 ? -1.0 : 1.0;
    const std::size_t place = k / 2;  // on this side
    double x = (static_cast<double>(place) + random.uniform(0.1, 0.8)) * each_m + 3.0;
    if (std::abs(x - side_street_m(length_m)) < kSideStreetHalf_m)
      x = side_street_m(length_m) + std::copysign(kSideStreetHalf_m, x - side_street_m(length_m));
    add_car(boxes, x, side * 5.9, side < 0 ? 0.0 : std::numbers::pi, random);
  }
}

/// In order of the levels: what `low` has, `mid` and `high` have too. Distances are from where the
/// drive begins; what drives ahead at our speed stays in view.
void add_traffic(std::vector<Box>& boxes, MovingLevel level, double ego_mps, double length_m,
                 Random random) {
  const auto car = [&](double x, double y, double yaw, double speed, double wrap,
                       double stand_s = 0.0) {
    DrivePath path;
    path.drive_s = stand_s > 0.0 ? 5.0 : 0.0;
    path.stand_s = stand_s;
    path.phase_s = stand_s > 0.0 ? random.uniform(0.0, 5.0) : 0.0;
    path.direction = {std::cos(yaw), std::sin(yaw), 0.0};
    path.speed_mps = speed;
    path.wrap_m = wrap;
    add_car(boxes, x, y, yaw, random, path);
  };
  constexpr double kQuarter = 0.5 * std::numbers::pi;
  constexpr double kOncoming_m = 3.3, kRight_m = -2.9;  // lanes; ours is 0
  const double round_m = length_m + 90.0;
  const double middle_m = 0.5 * length_m + 20.0;
  const double oncoming_mps = ego_mps * random.uniform(0.9, 1.1);
  const auto oncoming = [&](double x) {
    car(x, kOncoming_m, std::numbers::pi, oncoming_mps, round_m);
  };
  if (level >= MovingLevel::kLow) {
    oncoming(middle_m);
    add_person(boxes, 14.0, -8.2, {3.0, 0.4}, 16.0, random);
  }
  if (level >= MovingLevel::kMid) {
    DrivePath ahead;  // at our speed
    ahead.direction = Eigen::Vector3d::UnitX();
    ahead.speed_mps = ego_mps * 1.02;
    add_van(boxes, 10.0, 0.0, 0.0, random, ahead);
    car(side_street_m(length_m), 0.0, kQuarter, 3.0, 60.0, 2.0);  // crosses, stops and starts
  }
  if (level >= MovingLevel::kHigh) {
    car(6.0, kRight_m, 0.0, ego_mps * 1.03, 0.0);        // alongside, slowly getting away
    car(24.0, kRight_m, 0.0, ego_mps * 1.15, 0.0, 1.0);  // the same way, stops and starts
    oncoming(middle_m - 25.0);
    oncoming(middle_m - 50.0);
    add_person(boxes, 20.0, 8.2, {4.0, 0.3}, 14.0, random);
  }
}

}  // namespace

World make_street(std::uint64_t seed, MovingLevel moving, double ego_speed_mps, double length_m) {
  World world;
  Random random = stream(seed, Stream::kTexture);
  const double half_x = 0.5 * (length_m + 240.0);
  world.boxes.push_back(make_surroundings({0.5 * length_m, 0.0}, {half_x, 60.0, 25.0}));
  add_houses(world.boxes, length_m, random);
  add_kerbs(world.boxes, length_m);
  add_parked(world.boxes, length_m, random);
  add_traffic(world.boxes, moving, ego_speed_mps, length_m, stream(seed, Stream::kMovers));
  return world;
}

}  // namespace pled::sim
