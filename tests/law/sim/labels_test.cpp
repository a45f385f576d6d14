#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/frame_model.hpp"

using namespace pled;
using namespace pled::sim;

namespace {

SimulationOptions sharp(MovingLevel level, std::uint64_t seed) {
  SimulationOptions options = *preset("demo");
  options.seed = seed;
  options.moving = level;
  options.frames.exposure_s = 0.0;
  options.frames.blur_samples = 1;
  options.frames.noise_grey = 0.0;
  return options;
}

}  // namespace

TEST_SUITE("sim.labels") {
  TEST_CASE("outside the label a busy frame equals the empty room, inside it differs") {
    std::size_t labelled = 0;
    for (const std::uint64_t seed : {1U, 4U}) {
      const SimulationOptions busy = sharp(MovingLevel::kHigh, seed);
      const SimulationOptions empty = sharp(MovingLevel::kNone, seed);
      const World busy_world = make_room(seed, busy.moving);
      const World empty_world = make_room(seed, empty.moving);
      const Result<Renderer> busy_view = Renderer::create(busy_world, busy.camera);
      const Result<Renderer> empty_view = Renderer::create(empty_world, empty.camera);
      REQUIRE(busy_view.ok());
      REQUIRE(empty_view.ok());
      const RoomFlight flight{seed, StartKind::kMoving, 0.0};
      for (double t_s = 0.0; t_s < 6.0; t_s += 0.8) {
        const Frame a = expose_frame(busy_world, busy_view.value(), flight, busy, t_s, 0);
        const Frame b = expose_frame(empty_world, empty_view.value(), flight, empty, t_s, 0);
        std::size_t changed_outside = 0, inside = 0, changed_inside = 0;
        for (int y = 1; y < 179; ++y)
          for (int x = 1; x < 239; ++x) {
            const auto i = static_cast<std::size_t>(y * 240 + x);
            if (a.mask[i] == 255) {
              ++inside;
              changed_inside += a.grey[i] != b.grey[i];
              continue;
            }
            // A pixel beside an object shows a part of it.
            const bool beside =
                a.mask[i - 1] || a.mask[i + 1] || a.mask[i - 240] || a.mask[i + 240];
            if (!beside) changed_outside += a.grey[i] != b.grey[i];
          }
        CAPTURE(t_s);
        CHECK(changed_outside == 0);
        CHECK(static_cast<double>(changed_inside) >= 0.9 * static_cast<double>(inside));
        labelled += inside;
        for (const std::uint8_t m : b.mask) REQUIRE(m == 0);
      }
    }
    CHECK(labelled > 5000);  // there was something to see
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
