#include "pled_vins/reliability/line_motion_cue.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/geometry/line.hpp"
#include "support/reliability/random_scene.hpp"
#include "support/reliability/watched_lines.hpp"

namespace pled {
namespace {

using namespace support;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRests_px = 1.0;

/// Squared distances, px^2, of all earlier ends from the pictures of the line whose present ends
/// have these inverse depths.
double squares_px2(const std::vector<Pose>& path, const std::vector<Ends>& seen,
                   const Vector2d& rho) {
  const Vector3d p1 = seen.back()[0].homogeneous();
  const Vector3d p2 = seen.back()[1].homogeneous();
  // n = p_1 x p_2 and d = rho_1 p_2 - rho_2 p_1, so that infinity is a place like others.
  const PluckerLine now{p1.cross(p2), rho[0] * p2 - rho[1] * p1};
  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    const PluckerLine then = path[k].inverse() * path.back() * now;
    const std::optional<Vector3d> picture = project(then);
    if (!picture) return 1e9;
    for (const Vector2d& end : seen[k]) sum += std::pow(200.0 * picture->dot(end.homogeneous()), 2);
  }
  return sum;
}

/// The least over all pairs of depths from 0.2 m to infinity: tried on a grid, then on finer ones
/// around the best.
double least_squares_px2(const std::vector<Pose>& path, const std::vector<Ends>& seen) {
  constexpr int kSteps = 40;
  Vector2d middle(2.5, 2.5);
  double half = 2.5;
  double least = 1e18;
  for (int level = 0; level < 7; ++level) {
    Vector2d best = middle;
    for (int i = -kSteps / 2; i <= kSteps / 2; ++i)
      for (int k = -kSteps / 2; k <= kSteps / 2; ++k) {
        const Vector2d rho =
            (middle + 2.0 * half / kSteps * Vector2d(i, k)).cwiseMax(0.0).cwiseMin(5.0);
        const double here = squares_px2(path, seen, rho);
        if (here >= least) continue;
        least = here;
        best = rho;
      }
    middle = best;
    half *= 0.2;
  }
  return least;
}

}  // namespace

TEST_SUITE("reliability.line_motion_cue.law") {
  TEST_CASE("no depths fit a line's track much better than those that were found") {
    std::mt19937_64 random(3);
    int moving_seen = 0;
    int judged = 0;
    int found = 0;
    for (int n = 0; n < 20; ++n) {
      CAPTURE(n);
      RandomScene scene(random);
      WatchedLines watched;
      std::vector<Pose> path;
      std::vector<Segment3> segments;
      std::vector<Vector3d> speeds;
      for (int i = 0; i < 12; ++i) {
        const double z_m = scene.depth_m(1.2);  // 1.5 ... 16 m
        const Vector3d at = scene.place(z_m);
        segments.push_back(
            {at, at + 0.3 * z_m * scene.direction().cwiseProduct(Vector3d(1, 1, 0.3))});
        speeds.push_back(i % 2 == 0 ? scene.speed(z_m) : Vector3d::Zero());
      }
      std::vector<std::vector<Ends>> seen(segments.size());
      std::span<const LineMotionEvidence> out;
      for (int k = 0; k <= static_cast<int>(limits::kCueFrames); ++k) {
        path.push_back(scene.pose(k));
        std::vector<LineSighting> sightings;
        for (std::size_t i = 0; i < segments.size(); ++i) {
          // Another piece of the line each time.
          const Segment3 s = moved(segments[i], k * speeds[i]);
          const Segment3 piece{s[0] + 0.2 * scene.unit() * (s[1] - s[0]),
                               s[1] + 0.2 * scene.unit() * (s[1] - s[0])};
          Ends ends = ends_of(path.back(), piece);
          for (Vector2d& end : ends) end += scene.noise();
          seen[i].push_back(ends);
          sightings.push_back({kFirstImageLineId + static_cast<FeatureId>(i), ends});
        }
        out = watched.show(path.back(), sightings);
      }
      for (std::size_t i = 0; i < segments.size(); ++i) {
        CAPTURE(i);
        REQUIRE(out[i].frames == limits::kCueFrames);
        CHECK(out[i].freedoms > 9.9);
        CHECK(out[i].freedoms <= 12.0);
        const double least_px = std::sqrt(least_squares_px2(path, seen[i]) / out[i].freedoms);
        CHECK(out[i].residual_px >= least_px - 0.002);
        // A fit that is off by more is no line at rest, whatever its depths.
        if (!(least_px < kClearlyMoves_px)) continue;
        const bool is_least = out[i].residual_px <= 1.005 * least_px + 0.002;
        // Of a line that moves the sum may have two dips; the wrong one only makes it move more.
        if (least_px < kRests_px) CHECK(is_least);
        found += is_least ? 1 : 0;
        ++judged;
        moving_seen += out[i].residual_px > 1.0 ? 1 : 0;
      }
    }
    CHECK(judged > 160);
    CHECK(found > 0.96 * judged);
    CHECK(moving_seen > 20);  // both kinds took part
    CHECK(moving_seen < judged - 80);
  }
}

}  // namespace pled
