// Ours: what stands nearer than its surroundings is doubted, as far as depths are known.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/reliability/motion_cue.hpp"
#include "support/reliability/watched_points.hpp"

namespace pled {

using namespace support;

TEST_SUITE("reliability.motion_cue.nearness") {
  TEST_CASE("what stands nearer than its surroundings is doubted by the logarithm of how much") {
    constexpr double kApart = 0.3;  // plane z = 1
    const MotionCueConfig c;
    const double pooled = std::exp(-0.5 * kApart * kApart / (c.pool_radius * c.pool_radius));
    for (const double depth_m : {4.0, 1.0, 0.25}) {  // beside one at 4 m
      CAPTURE(depth_m);
      WatchedPoints watched(one_camera_rig());
      std::span<const MotionEvidence> out;
      for (int k = 0; k < 4; ++k) {
        const Eigen::Vector2d near = watched.bearing(sideways(k), {0.15, 0, depth_m});
        const Eigen::Vector2d far = watched.bearing(sideways(k), {0.15, 0, 4.0});
        // One above the other at the last frame, whatever their depths.
        const std::vector<Sighting> seen{{1, near - Eigen::Vector2d(0, kApart)}, {2, far}};
        out = watched.show(sideways(k), seen);
      }
      // Sideways they are 0.15 / depth - 0.15 / 4 apart.
      const double across = (0.15 - 3 * kStep_m) * (1.0 / depth_m - 0.25);
      REQUIRE(std::abs(across) < 1e-9);
      const double nearer = std::clamp(std::log((1.0 / depth_m + 0.1) / (0.25 + 0.1)), -1.5, 1.5);
      const double even = std::log(0.05 / c.even_px);
      // Of three earlier sights, 1, 2 and 3 steps back, each off by half of even_px, and all by the
      // newest's; sure to one half when that leaves open 0.3 of the inverse depth plus 0.1.
      const double sigma_pm = 0.5 * c.even_px / kFocal_px / kStep_m * std::sqrt(14.0 + 36.0) / 14.0;
      const auto sure = [&](double inverse_depth_pm) {
        return 1.0 / (1.0 + std::pow(sigma_pm / (0.3 * (inverse_depth_pm + 0.1)), 2));
      };
      const double near_belief = even + sure(1.0 / depth_m) * nearer;
      const double far_belief = even - sure(0.25) * nearer;
      CHECK(out[0].inverse_depth_sigma_pm == doctest::Approx(sigma_pm));
      const double belief =
          (c.own_weight * near_belief + pooled * far_belief) / (c.own_weight + pooled + 0.05);
      CHECK(out[0].w_static ==
            doctest::Approx(1.0 / (1.0 + std::exp(c.steepness * belief))).epsilon(1e-6));
    }
  }

  TEST_CASE("an oncoming car leaves no residual, but stands out") {
    constexpr double kAhead_m = 0.1;
    WatchedPoints watched(one_camera_rig());
    std::span<const MotionEvidence> out;
    for (int k = 0; k < 6; ++k) {
      const Pose pose{Eigen::Quaterniond::Identity(), {0, 0, kAhead_m * k}};
      std::vector<Sighting> seen{{1, watched.bearing(pose, {0.5, 0.2, 8.0 - 2 * kAhead_m * k})}};
      for (int i = 0; i < 12; ++i)  // houses around it, none nearer than where it is
        seen.push_back(
            {static_cast<FeatureId>(i + 2),
             watched.bearing(pose, {8.0 * std::cos(i * 0.5), 4.0 * std::sin(i * 0.5), 9.0 + i})});
      out = watched.show(pose, seen);
    }
    CHECK(out[0].residual_px < 0.1);
    // At 8 - 1 - 0.5 m it closes in three times as fast as what stands there.
    CHECK(out[0].inverse_depth_pm == doctest::Approx(3.0 / 6.5).epsilon(0.02));
    for (std::size_t i = 1; i < out.size(); ++i) CHECK(out[0].w_static < out[i].w_static);
  }

  TEST_CASE("a camera that hovers knows no depth, so nothing stands out") {
    std::mt19937_64 random(4);
    std::normal_distribution<double> noise(0.0, 0.2 / kFocal_px);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 100; ++i) {
      const double z = 3.0 + 2.0 * unit(random);
      points.push_back(z * Eigen::Vector3d(0.5 * unit(random), 0.4 * unit(random), 1.0));
    }
    WatchedPoints watched(one_camera_rig());
    std::span<const MotionEvidence> out;
    for (int k = 0; k < 7; ++k) {
      const Pose pose{Eigen::Quaterniond::Identity(), {1e-4 * k, 0, 0}};
      std::vector<Sighting> seen;
      for (std::size_t i = 0; i < points.size(); ++i)
        seen.push_back(
            {static_cast<FeatureId>(i + 1),
             watched.bearing(pose, points[i]) + Eigen::Vector2d(noise(random), noise(random))});
      out = watched.show(pose, seen);
    }
    for (const MotionEvidence& e : out) {
      CHECK_FALSE(e.depth_known);
      CHECK(e.w_static > 0.5);
    }
  }
}

}  // namespace pled
