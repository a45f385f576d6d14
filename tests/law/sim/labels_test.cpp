#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/sim/simulator.hpp"
#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/clearance.hpp"
#include "src/sim/frame_model.hpp"

using namespace pled;
using namespace pled::sim;

namespace {

SimulationOptions sharp(std::string_view name, MovingLevel level, std::uint64_t seed) {
  SimulationOptions options = *preset(name);
  options.seed = seed;
  options.moving = level;
  options.frames.exposure_s = 0.0;
  options.frames.blur_samples = 1;
  options.frames.noise_grey = 0.0;
  return options;
}

bool beside_label(const std::vector<std::uint8_t>& mask, std::size_t i) {
  for (const std::size_t row : {i - 240, i, i + 240})
    if (mask[row - 1] != 0 || mask[row] != 0 || mask[row + 1] != 0) return true;
  return false;
}

/// Something that stands and that one could drive into: no house, kerb or surroundings.
bool is_obstacle(const Box& box) {
  return !box.can_move() && !box.seen_from_inside && box.half_m.head<2>().maxCoeff() < 2.6;
}

/// Whether a part of a mover's ground plan, a grid of 5 x 5 points, lies in a box.
bool overlaps(const Box& mover, const Box& box, double t_s) {
  const Pose T_box_mover = box.T_world_rest.inverse() * mover.T_world_box(t_s);
  for (int i = -2; i <= 2; ++i)
    for (int k = -2; k <= 2; ++k) {
      const Eigen::Vector3d p{0.5 * i * mover.half_m.x(), 0.5 * k * mover.half_m.y(), 0.0};
      const Eigen::Array3d inside = (T_box_mover * p).array().abs();
      if (inside(0) < box.half_m.x() && inside(1) < box.half_m.y()) return true;
    }
  return false;
}

}  // namespace

TEST_SUITE("sim.labels") {
  TEST_CASE("outside the label a busy frame equals the empty world, inside it differs") {
    for (const std::string_view name : {"room", "car_park", "street"}) {
      CAPTURE(name);
      std::size_t labelled = 0;
      const std::uint64_t seed = 4;
      const SimulationOptions busy = sharp(name, MovingLevel::kHigh, seed);
      const SimulationOptions empty = sharp(name, MovingLevel::kNone, seed);
      const World busy_world = make_world(busy);
      const World empty_world = make_world(empty);
      const Result<Renderer> busy_view = Renderer::create(busy_world, busy.camera);
      const Result<Renderer> empty_view = Renderer::create(empty_world, empty.camera);
      REQUIRE(busy_view.ok());
      REQUIRE(empty_view.ok());
      const SineFlight flight(busy);
      for (double t_s = 0.0; t_s < 6.0; t_s += 1.1) {
        const Frame a = expose_frame(busy_world, busy_view.value(), flight, busy, t_s, 0);
        const Frame b = expose_frame(empty_world, empty_view.value(), flight, empty, t_s, 0);
        std::size_t changed_outside = 0, inside = 0, changed_inside = 0, standing = 0;
        for (const Box& box : busy_world.boxes)
          standing += box.can_move() && !(box.speed_mps(t_s) > kMovingSpeedMps) ? 1U : 0U;
        for (int y = 1; y < 179; ++y)
          for (int x = 1; x < 239; ++x) {
            const auto i = static_cast<std::size_t>(y * 240 + x);
            if (a.mask[i] == 255) {
              ++inside;
              changed_inside += a.grey[i] != b.grey[i];
              continue;
            }
            // A pixel beside an object, be it at a corner, shows a part of it.
            if (!beside_label(a.mask, i)) changed_outside += a.grey[i] != b.grey[i];
          }
        CAPTURE(t_s);
        // A car that waits is no mover then. What is thinner than a pixel may meet no centre.
        if (standing == 0)
          CHECK(static_cast<double>(changed_outside) <= 0.005 * static_cast<double>(inside));
        CHECK(static_cast<double>(changed_inside) >= 0.9 * static_cast<double>(inside));
        labelled += inside;
        for (const std::uint8_t m : b.mask) REQUIRE(m == 0);
      }
      CHECK(labelled > 1500);  // there was something to see
    }
  }

  TEST_CASE("each level adds to the one below and changes nothing of it") {
    for (const std::string_view name : {"room", "car_park", "street"}) {
      CAPTURE(name);
      World below = lay_out(sharp(name, MovingLevel::kNone, 2));
      for (const MovingLevel level : {MovingLevel::kLow, MovingLevel::kMid, MovingLevel::kHigh}) {
        World world = lay_out(sharp(name, level, 2));
        CHECK(world.boxes.size() > below.boxes.size());
        CHECK(world.boxes.size() <= Renderer::kMaxBoxes);
        for (std::size_t b = 0; b < below.boxes.size(); ++b) {
          const Pose a = below.boxes[b].T_world_box(1.7), c = world.boxes[b].T_world_box(1.7);
          REQUIRE(a.p == c.p);
          REQUIRE(below.boxes[b].half_m == world.boxes[b].half_m);
          REQUIRE(below.boxes[b].finish == world.boxes[b].finish);
        }
        below = std::move(world);
      }
    }
  }

  TEST_CASE("nothing drives or walks through parked cars and posts, or to where the rig goes") {
    for (const std::string_view name : {"car_park", "street"}) {
      CAPTURE(name);
      for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        CAPTURE(seed);
        const SimulationOptions options = sharp(name, MovingLevel::kHigh, seed);
        const World world = lay_out(options);
        const SineFlight flight(options);
        for (double t_s = 0.0; t_s < options.duration_s; t_s += 0.1) {
          const Eigen::Vector3d rig = flight.at(t_s).T_world_body.p;
          for (const Box& mover : world.boxes) {
            if (!mover.can_move()) continue;
            const Pose T_world_mover = mover.T_world_box(t_s);
            REQUIRE((T_world_mover.p - rig).head<2>().norm() > 1.5);
            for (const Box& box : world.boxes)
              if (is_obstacle(box)) REQUIRE_FALSE(overlaps(mover, box, t_s));
          }
        }
      }
    }
  }

  TEST_CASE(
      "every preset's flight keeps clear of walls for every seed, and one that does not is told") {
    for (const std::string_view name : kPresetNames) {
      CAPTURE(name);
      for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SimulationOptions options = *preset(name);
        options.seed = seed;
        CHECK_FALSE(first_contact_s(lay_out(options), SineFlight(options), options.duration_s));
      }
    }
    SimulationOptions options = *preset("room");
    options.motion = MotionKind::kCar;  // 5 m/s in a room of 8 m
    const auto contact_s = first_contact_s(lay_out(options), SineFlight(options), 8.0);
    REQUIRE(contact_s.has_value());
    CHECK(*contact_s < 2.0);  // 4.3 m to the wall, never below 2 m/s
    const auto refused = simulate(options, "/nowhere/that/is/written");
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::kUnsupported);
    CHECK(refused.error().detail == std::llround(*contact_s * 1e3));
  }

  TEST_CASE("what moves by itself changes no picture of what does not") {
    const World empty = make_world(sharp("room", MovingLevel::kNone, 2));
    const World busy = make_world(sharp("room", MovingLevel::kHigh, 2));
    for (std::size_t b = 0; b < empty.boxes.size(); ++b)
      for (std::size_t face = 0; face < 6; ++face)
        CHECK(empty.boxes[b].faces[face].sample(0.3F, 0.4F, 1e-4F) ==
              busy.boxes[b].faces[face].sample(0.3F, 0.4F, 1e-4F));
  }

  TEST_CASE("what drives has the speed it says, stops and starts gently, and comes round again") {
    DrivePath path;
    path.direction = {0.6, 0.8, 0.0};
    path.speed_mps = 3.0;
    path.drive_s = 6.0;
    path.stand_s = 2.0;
    path.phase_s = 1.3;
    constexpr double kStep = 1e-5;
    double top_mps = 0.0, least_mps = 9.0;
    for (double t_s = 0.01; t_s < 20.0; t_s += 0.037) {
      const Eigen::Vector3d way =
          path.displaced(Pose{}, t_s + kStep).p - path.displaced(Pose{}, t_s - kStep).p;
      const double along_mps = way.dot(path.direction) / (2 * kStep);
      CHECK(along_mps == doctest::Approx(path.speed_at(t_s)).epsilon(1e-4));
      CHECK(way.cross(path.direction).norm() < 1e-12);
      top_mps = std::max(top_mps, along_mps);
      least_mps = std::min(least_mps, along_mps);
    }
    CHECK(top_mps == doctest::Approx(3.0));
    CHECK(std::abs(least_mps) < 1e-6);
    path.wrap_m = 10.0;
    for (double t_s = 0.0; t_s < 30.0; t_s += 0.1)
      CHECK(path.displaced(Pose{}, t_s).p.norm() <= 5.0 + 1e-9);
  }

  TEST_CASE("a walker is labelled while it walks and not where it turns round") {
    const World world = make_room(1, MovingLevel::kLow);
    const Box& walker = world.boxes.back();
    REQUIRE(walker.can_move());
    // At a turning point of sin(rate t + phase) everything rests but the bob, whose speed is
    // bounded by 3 rate bob |cos 3 s|, zero there too.
    const double turn_s = (std::acos(-1.0) * 2.5 - walker.walk.phase_rad) / walker.walk.rate_radps;
    CHECK(walker.speed_mps(turn_s) < kMovingSpeedMps);
    CHECK(walker.speed_mps(turn_s + 0.5) > 0.1);
    // The bound holds for a corner of the box.
    const Eigen::Vector3d corner = walker.half_m;
    for (double t_s = 0.0; t_s < 5.0; t_s += 0.13) {
      const double speed_mps =
          (walker.T_world_box(t_s + 1e-4) * corner - walker.T_world_box(t_s - 1e-4) * corner)
              .norm() /
          2e-4;
      CHECK(speed_mps <= walker.speed_mps(t_s) + 1e-4);
    }
  }
}
