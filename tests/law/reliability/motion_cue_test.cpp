#include "pled_vins/reliability/motion_cue.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "support/reliability/random_scene.hpp"
#include "support/reliability/watched_points.hpp"

namespace pled {
namespace {

using support::kClearlyMoves_px;
using support::one_camera_rig;
using support::RandomScene;
using support::Sighting;
using support::WatchedPoints;

/// The least residual over all depths from 0.2 m to infinity, tried one after the other.
double least_residual_px(const std::vector<Pose>& path, const std::vector<Eigen::Vector2d>& seen) {
  const Pose& now = path.back();
  const auto residual_at = [&](double rho_pm) {
    double squares = 0.0;
    for (std::size_t k = 0; k + 1 < path.size(); ++k) {
      // rho p, so that infinity is a place like others.
      const Pose T_then_now = path[k].inverse() * now;
      const Eigen::Vector3d q = T_then_now.q * seen.back().homogeneous() + rho_pm * T_then_now.p;
      if (!(q.z() > 1e-3)) return 1e9;
      squares += (q.hnormalized() - seen[k]).squaredNorm();
    }
    return 200.0 * std::sqrt(squares / static_cast<double>(path.size() - 1));
  };
  constexpr int kSteps = 20'000;
  double best = 1e9;
  for (int i = 0; i <= kSteps; ++i) best = std::min(best, residual_at(5.0 * i / kSteps));
  return best;
}

}  // namespace

TEST_SUITE("reliability.motion_cue.law") {
  TEST_CASE("no depth fits a track much better than the one that was found") {
    std::mt19937_64 random(3);
    int moving_seen = 0;
    for (int n = 0; n < 12; ++n) {
      CAPTURE(n);
      RandomScene scene(random);
      WatchedPoints watched(one_camera_rig());
      std::vector<Pose> path;
      std::vector<Eigen::Vector3d> points, speeds;
      for (int i = 0; i < 25; ++i) {
        const double z_m = scene.depth_m(1.4);  // 1.2 ... 20 m
        points.push_back(scene.place(z_m));
        speeds.push_back(i % 3 == 0 ? scene.speed(z_m) : Eigen::Vector3d::Zero());
      }
      std::vector<std::vector<Eigen::Vector2d>> seen(points.size());
      std::span<const MotionEvidence> out;
      for (int k = 0; k <= static_cast<int>(limits::kCueFrames); ++k) {
        path.push_back(scene.pose(k));
        std::vector<Sighting> sightings;
        for (std::size_t i = 0; i < points.size(); ++i) {
          const Eigen::Vector2d at =
              watched.bearing(path.back(), points[i] + k * speeds[i]) + scene.noise();
          seen[i].push_back(at);
          sightings.push_back({static_cast<FeatureId>(i), at});
        }
        out = watched.show(path.back(), sightings);
      }
      for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        const double least_px = least_residual_px(path, seen[i]);
        CHECK(out[i].residual_px >= least_px - 0.002);
        // A fit that is off by more is no point at rest, whatever its depth.
        if (!(least_px < kClearlyMoves_px)) continue;
        CHECK(out[i].residual_px <= 1.02 * least_px + 0.01);
        moving_seen += out[i].residual_px > 1.0 ? 1 : 0;
      }
    }
    CHECK(moving_seen > 40);  // both kinds took part
  }
}

}  // namespace pled
