#include <array>
#include <cstring>
#include <set>

#include <doctest/doctest.h>

#include "support/frontend/tracked_scene.hpp"

namespace pled {
namespace {

using support::pose_at;
using support::quantile;
using support::TrackedScene;

constexpr double kOnePixelAtOneMetre = 1.0 / 199.0;

/// Two frames; at least 80 of the tracks survive, with these errors in half and in 90 % of them.
void check_two_frames(bool distorted, const Pose& first, const Pose& second,
                      const support::Exposure& exposure, double median_px, double most_px) {
  TrackedScene scene(distorted);
  scene.show(first);
  scene.show(second, exposure);
  const std::vector<double> errors = scene.errors_px();
  CHECK(errors.size() >= 80);
  CHECK(quantile(errors, 0.5) < median_px);
  CHECK(quantile(errors, 0.9) < most_px);
}

double distance_px(const PointMeasurement& a, const PointMeasurement& b) {
  return std::hypot(a.raw_px[0] - b.raw_px[0], a.raw_px[1] - b.raw_px[1]);
}

}  // namespace

TEST_SUITE("frontend.frame_tracker") {
  TEST_CASE("a shift of 0.37 px is measured to a few hundredths of a pixel") {
    check_two_frames(false, pose_at(0, 0, -1), pose_at(0.37 * kOnePixelAtOneMetre, 0, -1), {}, 0.03,
                     0.07);
  }
  TEST_CASE("a shift of 5.3 px that the gyro cannot foresee is measured as well") {
    check_two_frames(false, pose_at(0, 0, -1), pose_at(5.3 * kOnePixelAtOneMetre, 0, -1), {}, 0.04,
                     0.1);
  }
  TEST_CASE("a roll of 0.2 rad is followed with the gyro, through a distorting lens") {
    check_two_frames(true, pose_at(0, 0, -1), pose_at(0, 0, -1, {0, 0, 0.2}), {}, 0.04, 0.1);
  }
  TEST_CASE("a pan of 0.15 rad is followed with the gyro, through a distorting lens") {
    TrackedScene scene(true);
    scene.show(pose_at(0, 0, -1));
    scene.show(pose_at(0, 0, -1, {0, 0.15, 0}));
    const std::vector<double> errors = scene.errors_px();
    CHECK(errors.size() >= 60);  // the rest left the image
    CHECK(quantile(errors, 0.5) < 0.05);
    CHECK(quantile(errors, 0.9) < 0.12);
  }
  TEST_CASE("a zoom of 5 % is measured to a tenth of a pixel") {
    check_two_frames(false, pose_at(0, 0, -1), pose_at(0, 0, -1 / 1.05), {}, 0.1, 0.3);
  }
  TEST_CASE("half the light, or half as much again, does not move a point") {
    const Pose moved = pose_at(1.3 * kOnePixelAtOneMetre, 0, -1);
    check_two_frames(false, pose_at(0, 0, -1), moved, {.gain = 90, .offset = 15}, 0.04, 0.1);
    check_two_frames(false, pose_at(0, 0, -1), moved, {.gain = 200, .offset = 50}, 0.04, 0.1);
  }

  TEST_CASE("errors do not add up over 30 frames of turning, approaching and moving sideways") {
    TrackedScene scene(true);
    for (int k = 0; k < 31; ++k)
      scene.show(pose_at(0.1 * std::sin(0.1 * k), 0.06 * std::sin(0.13 * k), -1.0 + 0.006 * k,
                         {0.1 * std::sin(0.11 * k), 0.1 * std::sin(0.09 * k), 0.02 * k}),
                 {.noise_grey = 2.0});
    const std::vector<double> errors = scene.errors_px(31);
    CHECK(errors.size() >= 15);
    CHECK(quantile(errors, 0.5) < 0.12);
    CHECK(quantile(errors, 0.9) < 0.4);
  }

  TEST_CASE("corners keep their distance, reach every part of the image and have their own ids") {
    FrontendConfig config;
    config.min_distance_px = 12;
    TrackedScene scene(false, config);
    for (int k = 0; k < 6; ++k) {
      scene.show(pose_at(0.012 * k, 0.004 * k, -1));
      CAPTURE(k);
      const auto& points = scene.measured().points;
      CHECK(points.size() <= 120);
      std::array<int, 9> cells{};
      std::set<FeatureId> ids;
      for (std::size_t i = 0; i < points.size(); ++i) {
        ids.insert(points[i].id);
        ++cells[static_cast<std::size_t>(points[i].raw_px[0] / 80) +
                3 * static_cast<std::size_t>(points[i].raw_px[1] / 60)];
        for (std::size_t j = 0; j < i; ++j)  // tracks may drift closer, new corners may not be
          if (points[i].track_length == 1) CHECK(distance_px(points[i], points[j]) >= 11.99);
      }
      CHECK(ids.size() == points.size());
      CHECK(*std::min_element(cells.begin(), cells.end()) >= 1);
    }
  }

  TEST_CASE("tracks come before new corners, oldest first, and say how long they have lived") {
    TrackedScene scene(false);
    for (int k = 0; k < 5; ++k) scene.show(pose_at(0.03 * k, 0, -1));
    const auto& points = scene.measured().points;
    REQUIRE(points.size() > 20);
    CHECK(points.front().track_length == 5);
    CHECK(points.back().track_length == 1);
    for (std::size_t i = 1; i < points.size(); ++i)
      CHECK(points[i].track_length <= points[i - 1].track_length);
  }

  TEST_CASE("bearings are the undistorted pixels and their rate is the difference over time") {
    TrackedScene scene(true);
    scene.show(pose_at(0, 0, -1));
    std::map<FeatureId, std::array<double, 2>> before;
    for (const PointMeasurement& p : scene.measured().points) before[p.id] = p.bearing_xy;
    scene.show(pose_at(0.01, 0, -1));
    const Camera camera = support::davis240_camera(true);
    for (const PointMeasurement& p : scene.measured().points) {
      const auto bearing = camera.undistort({p.raw_px[0], p.raw_px[1]});
      REQUIRE(bearing);
      CHECK(p.bearing_xy[0] == doctest::Approx(bearing->x()));
      CHECK(p.bearing_xy[1] == doctest::Approx(bearing->y()));
      if (p.track_length < 2) continue;
      const std::array<double, 2> was = before.at(p.id);
      CHECK(p.bearing_rate_xyps[0] == doctest::Approx((p.bearing_xy[0] - was[0]) / 0.05));
      CHECK(p.bearing_rate_xyps[1] == doctest::Approx((p.bearing_xy[1] - was[1]) / 0.05));
    }
  }

  TEST_CASE("flow is what moved, parallax what the rotation does not explain") {
    TrackedScene scene(false);
    scene.show(pose_at(0, 0, -1));
    scene.show(pose_at(2.0 * kOnePixelAtOneMetre, 0, -1));
    CHECK(scene.measured().median_flow_px == doctest::Approx(2.0).epsilon(0.03));
    CHECK(scene.measured().median_parallax_px == doctest::Approx(2.0).epsilon(0.03));
    scene.show(pose_at(2.0 * kOnePixelAtOneMetre, 0, -1, {0, 0.05, 0}));
    CHECK(scene.measured().median_flow_px > 9.0);  // f x 0.05 rad
    CHECK(scene.measured().median_parallax_px < 0.1);
  }

  TEST_CASE("the same frames give the same bytes") {
    TrackedScene a(true);
    TrackedScene b(true);
    for (int k = 0; k < 6; ++k) {
      const Pose pose = pose_at(0.02 * k, 0.01 * k, -1, {0, 0, 0.05 * k});
      const auto image = a.render(pose, {.noise_grey = 3.0});
      a.show(pose, image);
      b.show(pose, image);
      REQUIRE(a.measured().points.size() == b.measured().points.size());
      CHECK(std::memcmp(&a.measured().points[0], &b.measured().points[0],
                        a.measured().points.size() * sizeof(PointMeasurement)) == 0);
    }
  }
}

}  // namespace pled
