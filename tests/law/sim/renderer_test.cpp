#include "src/sim/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/step_planner.hpp"
#include "tests/support/room_flight.hpp"

using namespace pled;
using namespace pled::sim;

namespace {

/// A grey room with one black disc on the far wall, at (u, v) metres of its picture.
World room_with_disc(double u_m, double v_m, double radius_m) {
  World world;
  Box room;
  room.half_m = {4.0, 3.5, 1.5};
  room.T_world_rest.p = {0.4, 0.0, 1.5};
  room.seen_from_inside = true;
  for (std::size_t f = 0; f < 6; ++f) {
    room.faces[f] = f < 2   ? Texture{7.0, 3.0, 0.005}
                    : f < 4 ? Texture{8.0, 3.0, 0.02}
                            : Texture{8.0, 7.0, 0.02};
    for (int y = 0; y < room.faces[f].height(); ++y)
      for (int x = 0; x < room.faces[f].width(); ++x) room.faces[f].at(y, x) = 0.5F;
  }
  Texture& wall = room.faces[1];  // +x
  for (int y = 0; y < wall.height(); ++y)
    for (int x = 0; x < wall.width(); ++x)
      if (std::hypot((x + 0.5) * 0.005 - u_m, (y + 0.5) * 0.005 - v_m) < radius_m)
        wall.at(y, x) = 0.0F;
  for (Texture& face : room.faces) face.build_levels();
  world.boxes.push_back(std::move(room));
  return world;
}

}  // namespace

TEST_SUITE("sim.renderer") {
  TEST_CASE("a mark on a wall is drawn where its point projects, all along the flight") {
    const double u_m = 3.3, v_m = 1.6;
    const World world = room_with_disc(u_m, v_m, 0.06);
    const Eigen::Vector3d mark{4.4, u_m - 3.5, v_m};  // the wall's corner is (4.4, -3.5, 0)
    const CameraCalibration calibration = davis240c_camera();
    const Camera camera{calibration};
    const Result<Renderer> renderer = Renderer::create(world, calibration);
    REQUIRE(renderer.ok());
    const SineFlight flight = room_flight(1, StartKind::kMoving, 0.0);
    int seen = 0;
    View view;
    for (double t_s = 0.0; t_s < 8.0; t_s += 0.1) {
      const Pose T_world_cam = flight.at(t_s).T_world_body * calibration.T_body_cam;
      const auto px = camera.project(T_world_cam.inverse() * mark);
      if (!px || !camera.inside(*px, 12.0)) continue;
      renderer.value().render(T_world_cam, t_s, view);
      const int cx = static_cast<int>(std::lround(px->x()));
      const int cy = static_cast<int>(std::lround(px->y()));
      const auto at = [&](int y, int x) {
        return static_cast<double>(view.radiance[static_cast<std::size_t>(y * 240 + x)]);
      };
      const double ground = at(cy - 10, cx - 10);
      Eigen::Vector2d sum = Eigen::Vector2d::Zero();
      double weight = 0.0;
      for (int y = cy - 10; y <= cy + 10; ++y)
        for (int x = cx - 10; x <= cx + 10; ++x) {
          const double dark = std::max(0.0, ground - at(y, x));
          sum += dark * Eigen::Vector2d{x, y};
          weight += dark;
        }
      REQUIRE(weight > 0.1);
      CAPTURE(t_s);
      CHECK((sum / weight - *px).norm() < 0.1);
      ++seen;
    }
    CHECK(seen > 20);
  }

  TEST_CASE("depth is the distance along the optical axis to what the pixel shows") {
    const World world = room_with_disc(1.0, 1.0, 0.05);
    const CameraCalibration calibration = davis240c_camera();
    const Result<Renderer> renderer = Renderer::create(world, calibration);
    REQUIRE(renderer.ok());
    const SineFlight flight = room_flight(2, StartKind::kMoving, 0.0);
    const Pose T_world_cam = flight.at(0.7).T_world_body * calibration.T_body_cam;
    View view;
    renderer.value().render(T_world_cam, 0.7, view);
    for (std::size_t i = 0; i < view.depth_m.size(); i += 97) {
      const Eigen::Vector2d ray = renderer.value().ray(i).cast<double>();
      const Eigen::Vector3d p =
          T_world_cam * (static_cast<double>(view.depth_m[i]) * ray.homogeneous());
      const Eigen::Vector3d in_room = (p - Eigen::Vector3d{0.4, 0.0, 1.5}).cwiseAbs();
      const Eigen::Vector3d to_wall = Eigen::Vector3d{4.0, 3.5, 1.5} - in_room;
      CHECK(std::abs(to_wall.minCoeff()) < 1e-4);  // on a wall, within float
      CHECK(to_wall(view.surface[i] / 2) == doctest::Approx(0.0).epsilon(1e-4));
    }
  }

  TEST_CASE("reading a fine chequered picture from afar gives its mean, without flicker") {
    Texture texture{1.0, 1.0, 0.004};
    for (int y = 0; y < texture.height(); ++y)
      for (int x = 0; x < texture.width(); ++x)
        texture.at(y, x) = (x / 2 + y / 2) % 2 == 0 ? 0.0F : 1.0F;
    texture.build_levels();
    for (float u = 0.3F; u < 0.7F; u += 0.0137F)  // squares of 8 mm under a pixel of 64 mm
      CHECK(texture.sample(u, 0.51F, 0.064F * 0.064F) == doctest::Approx(0.5).epsilon(0.02));
    CHECK(texture.sample(0.012F, 0.012F, 1e-8F) == doctest::Approx(0.0));  // inside a black square
  }

  TEST_CASE("no pixel of a planned step moves further than allowed") {
    SimulationOptions options = *preset("room");
    options.moving = MovingLevel::kHigh;
    options.events.max_step_s = 0.02;  // so that the motion decides
    World world = make_room(3, options.moving);
    paint_boxes(world, 3);
    const Camera camera{options.camera};
    const Result<Renderer> renderer = Renderer::create(world, options.camera);
    REQUIRE(renderer.ok());
    const SineFlight flight = room_flight(3, StartKind::kMoving, 0.0);
    View view;
    for (double t_s = 0.2; t_s < 4.0; t_s += 0.45) {
      CAPTURE(t_s);
      const Pose T_world_cam = flight.at(t_s).T_world_body * options.camera.T_body_cam;
      renderer.value().render(T_world_cam, t_s, view);
      const double step_s = plan_step_s(world, renderer.value(), flight, options, view, t_s);
      const Pose T_next_world =
          (flight.at(t_s + step_s).T_world_body * options.camera.T_body_cam).inverse();
      double fastest_px = 0.0;
      for (std::size_t i = 0; i < view.depth_m.size(); i += 7) {
        const Box& box = world.boxes[view.surface[i] / 6U];
        const Eigen::Vector3d p_cam = static_cast<double>(view.depth_m[i]) *
                                      renderer.value().ray(i).cast<double>().homogeneous();
        const Pose carried = box.T_world_box(t_s + step_s) * box.T_world_box(t_s).inverse();
        const auto now = camera.project(p_cam);
        const auto next = camera.project(T_next_world * (carried * (T_world_cam * p_cam)));
        if (now && next) fastest_px = std::max(fastest_px, (*next - *now).norm());
      }
      CHECK(fastest_px < 0.55);  // 0.5 and what the 8-px grid may miss
      CHECK(fastest_px > 0.2);   // and the step is not needlessly short
    }
  }
}
