// A corner of the world stays where its reprojection says, as the product's own tracker sees it.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/frontend/frame_tracker.hpp"
#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/frame_model.hpp"

using namespace pled;
using namespace pled::sim;

namespace {

constexpr std::size_t kFrames = 24;
constexpr std::uint32_t kLongest = 12;  // frames over which a point is compared

/// Depth at a place between pixels. On a plane one over depth is linear in the image, to first
/// order of the lens; at an edge of depth, and far away, there is none.
std::optional<double> depth_m(const Frame& frame, int width, const Eigen::Vector2d& px) {
  const int x = static_cast<int>(std::floor(px.x())), y = static_cast<int>(std::floor(px.y()));
  const auto inverse = [&](int dy, int dx) {
    const auto mm = frame.depth_mm[static_cast<std::size_t>((y + dy) * width + x + dx)];
    return mm > 0 ? 1e3 / mm : 0.0;
  };
  const double a = inverse(0, 0), b = inverse(0, 1), c = inverse(1, 0), d = inverse(1, 1);
  const double least = std::min({a, b, c, d}), most = std::max({a, b, c, d});
  if (!(least > 0.0) || most > 1.05 * least) return std::nullopt;
  const double u = px.x() - x, v = px.y() - y;
  return 1.0 / ((1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d));
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Distances of tracked points to the reprojection of the point of the world that they began at.
std::vector<double> reprojection_errors_px(const SimulationOptions& options) {
  using Storage = FrameTrackerStorage<240, 180>;
  const World world = make_world(options);
  const Result<Renderer> renderer = Renderer::create(world, options.camera);
  REQUIRE(renderer.ok());
  const SineFlight flight(options);
  const Camera camera{options.camera};
  const auto storage = std::make_unique<Storage>();
  FrameTracker tracker(FrontendConfig{}, camera, storage->view());
  FrameMeasurement seen;
  std::map<FeatureId, Eigen::Vector3d> points_world;
  std::vector<double> errors_px;
  std::optional<Pose> T_world_last;
  for (std::size_t k = 0; k < kFrames; ++k) {
    const double t_s = 0.05 * static_cast<double>(k);
    const Frame frame = expose_frame(world, renderer.value(), flight, options, t_s, k);
    const Pose T_world_cam = flight.at(t_s).T_world_body * options.camera.T_body_cam;
    FrameView view;
    view.t = Timestamp{static_cast<std::int64_t>(k) * 50'000};
    view.image = {frame.grey.data(), options.camera.width_px, options.camera.height_px,
                  options.camera.width_px};
    std::optional<Eigen::Quaterniond> R_last_cam;
    if (T_world_last) R_last_cam = T_world_last->q.conjugate() * T_world_cam.q;
    REQUIRE(tracker.track(view, view.t, R_last_cam, seen));
    for (const PointMeasurement& p : seen.points) {
      const Eigen::Vector2d px{p.raw_px[0], p.raw_px[1]};
      if (p.track_length == 1) {
        if (const auto z_m = depth_m(frame, options.camera.width_px, px))
          points_world[p.id] =
              T_world_cam * (*z_m * Eigen::Vector2d(p.bearing_xy.data()).homogeneous());
        continue;
      }
      const auto point = points_world.find(p.id);
      if (point == points_world.end() || p.track_length > kLongest) continue;
      const auto expected_px = camera.project(T_world_cam.inverse() * point->second);
      if (expected_px) errors_px.push_back((px - *expected_px).norm());
    }
    T_world_last = T_world_cam;
  }
  return errors_px;
}

}  // namespace

TEST_SUITE("sim.reprojection") {
  TEST_CASE("tracked corners stay within 0.3 px of their reprojections, in every world") {
    for (const std::string_view name : {"room", "car_park", "street"}) {
      CAPTURE(name);
      SimulationOptions options = *preset(name);
      options.moving = MovingLevel::kNone;
      options.with_depth = true;
      const std::vector<double> errors_px = reprojection_errors_px(options);
      REQUIRE(errors_px.size() > 500);
      const double half_px = median(errors_px);
      MESSAGE(std::string(name), ": median ", half_px, " px of ", errors_px.size());
      CHECK(half_px < 0.3);
    }
  }
}
