// The bus, and surfaces of spots and of stripes.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/frontend/lines/segment_finder.hpp"
#include "pled_vins/sim/simulator.hpp"
#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/bus.hpp"
#include "src/sim/frame_model.hpp"

using namespace pled;
using namespace pled::sim;

namespace {

SimulationOptions sharp(WorldKind kind, const BusOptions& bus) {
  SimulationOptions options = *preset(kind == WorldKind::kRoom ? "room" : "car_park");
  options.moving = MovingLevel::kNone;
  options.bus = bus;
  options.frames.exposure_s = 0.0;
  options.frames.blur_samples = 1;
  options.frames.noise_grey = 0.0;
  return options;
}

/// Segments of 15 pixels and more in a picture of the room, without the bound on followed lines.
std::size_t straight_edges(Surfaces surfaces, double t_s) {
  SimulationOptions options = sharp(WorldKind::kRoom, {});
  options.surfaces = surfaces;
  const World world = make_world(options);
  const Result<Renderer> renderer = Renderer::create(world, options.camera);
  REQUIRE(renderer.ok());
  const Frame frame = expose_frame(world, renderer.value(), SineFlight(options), options, t_s, 0);
  std::vector<ShrunkPiece> pieces(4096);
  std::size_t found = 0;
  REQUIRE(find_pieces({frame.grey.data(), options.camera.width_px, options.camera.height_px,
                       options.camera.width_px},
                      15.0, pieces, found));
  return found;
}

}  // namespace

TEST_SUITE("sim.scenes") {
  TEST_CASE("a bus is before the rig at its time, never nearer than told, and stands as long") {
    for (const double stand_s : {0.0, 2.5})
      for (const double away_m : {2.0, 7.0}) {
        CAPTURE(stand_s);
        CAPTURE(away_m);
        const BusOptions bus{.at_s = 4.0, .stand_s = stand_s, .away_m = away_m};
        const SimulationOptions options = sharp(WorldKind::kCarPark, bus);
        const SineFlight flight(options);
        const Box box = make_bus(bus, flight);
        const Pose rig = flight.at(4.0).T_world_body;
        // Level sight: what lies on it has no share along the way that the bus takes.
        const Eigen::Vector3d to_bus = box.T_world_box(4.0).p - rig.p;
        CHECK(std::abs(to_bus.dot(box.drive.direction)) < 1e-9);
        CHECK((rig.q.conjugate() * to_bus).z() > away_m);
        double nearest_m = 1e9, stood_s = 0.0;
        for (double t_s = 2.0; t_s < 6.0 + stand_s; t_s += 0.01) {
          const Pose T_box_rig = box.T_world_box(t_s).inverse() * flight.at(t_s).T_world_body;
          nearest_m = std::min(nearest_m, std::abs(T_box_rig.p.y()) - box.half_m.y());
          stood_s += box.speed_mps(t_s) == 0.0 ? 0.01 : 0.0;
        }
        CHECK(nearest_m == doctest::Approx(away_m).epsilon(0.01));
        CHECK(stood_s == doctest::Approx(stand_s).epsilon(0.01));
        const double left_m =
            (box.T_world_box(8.0 + stand_s).p - to_bus - rig.p).dot(box.drive.direction);
        CHECK(left_m > 15.0);
      }
  }

  TEST_CASE(
      "from 2 m a bus fills the view, and is labelled while it drives and not while it stands") {
    const BusOptions bus{.at_s = 3.0, .stand_s = 2.0, .away_m = 2.0};
    SimulationOptions options = sharp(WorldKind::kCarPark, bus);
    options.motion = MotionKind::kStill;
    const SineFlight stand(options);
    World world = lay_out(options);
    world.boxes.push_back(make_bus(bus, stand));
    paint_boxes(world, options.seed);
    const Result<Renderer> renderer = Renderer::create(world, options.camera);
    REQUIRE(renderer.ok());
    const auto labelled = [&](double t_s) {
      const Frame frame = expose_frame(world, renderer.value(), stand, options, t_s, 0);
      return static_cast<double>(std::ranges::count(frame.mask, std::uint8_t{255})) /
             static_cast<double>(frame.mask.size());
    };
    CHECK(labelled(0.5) == 0.0);  // not there yet
    CHECK(labelled(2.7) > 0.9);   // about to stand
    CHECK(labelled(4.0) == 0.0);  // standing
    CHECK(labelled(5.25) > 0.9);  // off again
    CHECK(labelled(8.5) == 0.0);  // gone
  }

  TEST_CASE("spots have hardly a straight edge, stripes far more than what a room shows") {
    for (const double t_s : {0.5, 2.0, 4.0}) {
      CAPTURE(t_s);
      const std::size_t usual = straight_edges(Surfaces::kUsual, t_s);
      const std::size_t pebbles = straight_edges(Surfaces::kPebbles, t_s);
      const std::size_t stripes = straight_edges(Surfaces::kStripes, t_s);
      MESSAGE(pebbles << " segments on spots, " << usual << " usually, " << stripes
                      << " on stripes");
      CHECK(10 * pebbles < usual);
      CHECK(2 * usual < stripes);
    }
  }
}
