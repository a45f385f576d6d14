#include "pled_vins/reliability/line_motion_cue.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"
#include "support/reliability/watched_lines.hpp"

namespace pled {
namespace {

using namespace support;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kFrames = 7;
const Segment3 kPost{Vector3d(0.2, -0.5, 2.0), Vector3d(0.3, 0.5, 2.2)};
const Segment3 kRail{Vector3d(-0.4, 0.3, 2.0), Vector3d(0.6, 0.3, 2.0)};  ///< along the way

/// What is found of one line that moves by `step_m` from frame to frame while the camera goes by
/// `path(k)`. Each time a different piece of it is seen.
template <typename Path>
LineMotionEvidence watch(const Path& path, const Segment3& segment, const Vector3d& step_m,
                         int frames = kFrames) {
  WatchedLines watched;
  LineMotionEvidence out;
  for (int k = 0; k < frames; ++k) {
    const Segment3 s = moved(segment, k * step_m);
    const Vector3d along = 0.1 * (k % 3) * (s[1] - s[0]);
    const std::vector<LineSighting> seen{
        {kFirstImageLineId, ends_of(path(k), {s[0] + along, s[1] - 0.5 * along})}};
    out = watched.show(path(k), seen)[0];
  }
  return out;
}

Pose turning(int k) { return {so3::exp({0.02 * k, 0.03 * k, -0.02 * k}), Vector3d::Zero()}; }

/// Depth at the ends that are seen in the last frame of watch().
double depth_at(const Segment3& segment, double part) {
  return (segment[0] + part * (segment[1] - segment[0])).z();
}

}  // namespace

TEST_SUITE("reliability.line_motion_cue") {
  TEST_CASE("a line at rest leaves nothing, and has its depths, whatever pieces of it are seen") {
    const LineMotionEvidence e = watch(sideways, kPost, Vector3d::Zero());
    CHECK(e.frames == 6);
    CHECK(e.residual_px < 0.01);
    CHECK(e.freedoms == doctest::Approx(10.0).epsilon(0.02));
    CHECK(e.depth_known);
    CHECK(e.inverse_depth_pm[0] == doctest::Approx(1.0 / depth_at(kPost, 0.0)).epsilon(1e-3));
    CHECK(e.inverse_depth_pm[1] == doctest::Approx(1.0 / depth_at(kPost, 1.0)).epsilon(1e-3));
    CHECK(e.w_static > 0.9);
  }

  TEST_CASE("a line that moves across itself, against what depth allows, is found") {
    // Twice as fast as the camera, and in its direction: seen going where nothing at rest goes.
    const LineMotionEvidence e = watch(sideways, kPost, {2.0 * kStep_m, 0, 0});
    CHECK(e.residual_px > 3.0);
    CHECK(e.w_static < 0.05);
    CHECK(e.inverse_depth_pm[0] == 0.0);
    // So does one that sways.
    WatchedLines watched;
    LineMotionEvidence swaying;
    for (int k = 0; k < kFrames; ++k) {
      const Segment3 s = moved(kPost, {0.05 * (k % 2), 0, 0});
      const std::vector<LineSighting> seen{{kFirstImageLineId, ends_of(sideways(k), s)}};
      swaying = watched.show(sideways(k), seen)[0];
    }
    CHECK(swaying.residual_px > 1.0);
    CHECK(swaying.w_static < 0.2);
  }

  TEST_CASE("what one line cannot show is not found: motion along it, with the camera, or steady") {
    const LineMotionEvidence along = watch(sideways, kPost, 0.05 * (kPost[1] - kPost[0]));
    CHECK(along.residual_px < 0.01);
    const LineMotionEvidence with = watch(sideways, kPost, {kStep_m, 0, 0});
    CHECK(with.residual_px < 0.01);
    CHECK(with.inverse_depth_pm[0] < 1e-3);
    // Against the camera as fast as it goes: as a line at rest at half the distance.
    const LineMotionEvidence steady = watch(sideways, kPost, {-kStep_m, 0, 0});
    CHECK(steady.residual_px < 0.05);
    CHECK(steady.inverse_depth_pm[0] == doctest::Approx(2.0 / depth_at(kPost, 0.0)).epsilon(0.02));
  }

  TEST_CASE("where the camera goes along the line, or only turns, depths explain nothing away") {
    const auto ahead = [](int k) { return Pose{Eigen::Quaterniond::Identity(), {0, 0, 0.05 * k}}; };
    const Segment3 lane{Vector3d(0.0, 0.4, 2.0), Vector3d(0.0, 0.4, 4.0)};
    for (const int frames : {2, 7}) {
      CAPTURE(frames);
      const double all = 2.0 * (frames - 1);
      const LineMotionEvidence rail = watch(sideways, kRail, Vector3d::Zero(), frames);
      CHECK(rail.residual_px < 0.01);
      CHECK(rail.freedoms == doctest::Approx(all));
      CHECK_FALSE(rail.depth_known);
      CHECK(rail.w_static > 0.9);
      const LineMotionEvidence falling = watch(sideways, kRail, {0, -0.03, 0}, frames);
      CHECK(falling.freedoms == doctest::Approx(all));
      CHECK(falling.residual_px > 2.0);
      CHECK(falling.w_static < 0.1);
      CHECK(watch(ahead, lane, Vector3d::Zero(), frames).w_static > 0.9);
      CHECK(watch(ahead, lane, {0.03, 0, 0}, frames).w_static < 0.2);
      const LineMotionEvidence still = watch(turning, kPost, Vector3d::Zero(), frames);
      CHECK(still.freedoms == doctest::Approx(all));
      CHECK(still.residual_px < 0.01);
      CHECK(still.w_static > 0.9);
      CHECK_FALSE(still.depth_known);
      CHECK(watch(turning, kPost, {0.03, 0, 0}, frames).w_static < 0.1);
    }
  }

  TEST_CASE("two sights of a line across the camera's way are no evidence, three are") {
    const LineMotionEvidence one = watch(sideways, kPost, {2.0 * kStep_m, 0, 0}, 1);
    CHECK(one.frames == 0);
    CHECK(std::isnan(one.w_static));
    CHECK(std::isnan(one.inverse_depth_pm[0]));
    const LineMotionEvidence two = watch(sideways, kPost, Vector3d::Zero(), 2);
    CHECK(two.frames == 1);
    CHECK(two.freedoms < 0.5);
    CHECK(std::isnan(two.residual_px));
    CHECK(std::isnan(two.w_static));
    CHECK(two.inverse_depth_pm[0] == doctest::Approx(1.0 / depth_at(kPost, 0.1)).epsilon(1e-3));
    const LineMotionEvidence three = watch(sideways, kPost, Vector3d::Zero(), 3);
    CHECK(three.freedoms >= 2.0);
    CHECK(three.w_static > 0.5);
  }

  TEST_CASE("a line seen for the first time is judged by points and lines beside it") {
    for (const bool moves : {false, true}) {
      CAPTURE(moves);
      const Vector3d step(0, moves ? 0.05 : 0.0, 0);
      // A point 5 px beside the post's middle, one at its end, and a line beside it; then a post
      // far from all.
      WatchedLines by_points, by_lines;
      std::vector<double> w(3);
      for (int k = 0; k < 4; ++k) {
        const auto px = [&](const Vector3d& p) -> Vector2d {
          return (sideways(k).inverse() * (p + k * step)).hnormalized();
        };
        const std::vector<Sighting> points{{1, px({0.3, 0.0, 2.1})}, {2, px({0.2, -0.5, 2.0})}};
        std::vector<LineSighting> lines;
        std::vector<LineSighting> beside{
            {kFirstImageLineId + 9, ends_of(sideways(k), moved(kRail, k * step))}};
        if (k == 3) {
          lines.push_back({kFirstImageLineId, ends_of(sideways(k), kPost)});
          lines.push_back({kFirstImageLineId + 1, {Vector2d(-0.6, -0.3), Vector2d(-0.6, 0.3)}});
          beside.push_back({kFirstImageLineId, {Vector2d(-0.1, 0.13), Vector2d(0.1, 0.16)}});
        }
        const auto out = by_points.show(sideways(k), lines, points);
        const auto near = by_lines.show(sideways(k), beside);
        if (k < 3) continue;
        w = {out[0].w_static, out[1].w_static, near[1].w_static};
      }
      CHECK((w[0] > 0.9) == !moves);
      CHECK((w[0] < 0.1) == moves);
      CHECK(std::isnan(w[1]));
      CHECK((w[2] > 0.9) == !moves);
      CHECK((w[2] < 0.1) == moves);
    }
  }

  TEST_CASE("a line that stands out towards the camera from points around it is doubted") {
    // Steadily against the camera's way, so it looks nearer than the wall it is before.
    std::vector<double> w;
    for (const double against_m : {0.0, 0.1}) {
      WatchedLines watched;
      for (int k = 0; k < kFrames; ++k) {
        std::vector<Sighting> wall;
        for (int i = 0; i < 8; ++i) {
          const Vector3d p(1.0 + 0.5 * (i % 4), i < 4 ? -0.9 : 0.9, 3.5);
          wall.push_back(
              {static_cast<FeatureId>(i + 1), (sideways(k).inverse() * p).hnormalized()});
        }
        const Segment3 post = moved(kPost, {-against_m * k, 0, 0.8});
        const std::vector<LineSighting> seen{{kFirstImageLineId, ends_of(sideways(k), post)}};
        const auto out = watched.show(sideways(k), seen, wall);
        if (k == kFrames - 1) w.push_back(out[0].w_static);
      }
    }
    CHECK(w[1] < w[0]);
  }

  TEST_CASE("a line that was missing for two pictures is judged by those it was seen in") {
    WatchedLines watched;
    LineMotionEvidence out;
    for (int k = 0; k < kFrames; ++k) {
      std::vector<LineSighting> seen{
          {kFirstImageLineId + 5, {Vector2d(-0.5, 0), Vector2d(-0.4, 0)}}};
      if (k != 3 && k != 4) seen.push_back({kFirstImageLineId, ends_of(sideways(k), kPost)});
      const auto all = watched.show(sideways(k), seen);
      out = all.back();
    }
    CHECK(out.frames == 4);
    CHECK(out.residual_px < 0.01);
    CHECK(watched.cue().ends(kFirstImageLineId, 0, 1).has_value());
    CHECK_FALSE(watched.cue().ends(kFirstImageLineId, 2, 1));
    CHECK(watched.cue().ends(kFirstImageLineId, 5, 0).has_value());
    CHECK_FALSE(watched.cue().ends(kFirstImageLineId, 6, 0));
    watched.cue().reset();
    CHECK_FALSE(watched.cue().ends(kFirstImageLineId, 0, 0));
    const std::vector<LineSighting> seen{{kFirstImageLineId, ends_of(sideways(7), kPost)}};
    CHECK(watched.show(sideways(7), seen)[0].frames == 0);
  }

  TEST_CASE("lines of events may leave more") {
    const MotionCueConfig c;
    std::vector<double> w;
    for (const FeatureId id : {kFirstImageLineId, kFirstEventLineId}) {
      WatchedLines watched;
      std::span<const LineMotionEvidence> out;
      for (int k = 0; k < kFrames; ++k) {
        // Sways along the picture's y by 1 px to either side.
        Ends ends = ends_of(sideways(k), kRail);
        for (Vector2d& end : ends) end.y() += (k % 2 == 0 ? 1.0 : -1.0) / kFocal_px;
        const std::vector<LineSighting> seen{{id, ends}};
        out = watched.show(sideways(k), seen);
      }
      // Three sights as now, three 2 px off, at both ends; no depth has a say.
      const double residual_px = std::sqrt(3.0 * 4.0 * 2.0 / 12.0);
      CHECK(out[0].residual_px == doctest::Approx(residual_px).epsilon(1e-4));
      const bool of_events = id == kFirstEventLineId;
      const double even = of_events ? c.event_even_px : c.even_px;
      const double say = c.own_weight * (of_events ? c.event_weight : 1.0);
      const double belief = std::log(residual_px / even) * say / (say + 0.05);
      CHECK(out[0].w_static ==
            doctest::Approx(1.0 / (1.0 + std::exp(c.steepness * belief))).epsilon(1e-3));
    }
  }

  TEST_CASE("values that are not finite are no evidence, and keep to themselves") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const Vector2d hole(nan, 0.1);
    WatchedLines watched;
    for (int k = 0; k < kFrames + 3; ++k) {
      const Ends post = ends_of(sideways(k), kPost);
      const Ends rail = ends_of(sideways(k), kRail);
      const std::vector<LineSighting> seen{
          {kFirstImageLineId, post},
          {kFirstImageLineId + 1, k == 4 ? Ends{rail[0], hole} : rail},
          {kFirstImageLineId + 2, {hole, hole}},
          {kFirstImageLineId + 3, {post[0], post[0]}}};  // no line at all
      const std::vector<Sighting> points{{1, hole}};
      const auto out = watched.show(sideways(k), seen, points);
      if (k < 2) continue;
      CAPTURE(k);
      CHECK(out[0].w_static > 0.9);
      CHECK(out[0].residual_px < 0.01);
      CHECK(std::isnan(out[2].w_static));
      CHECK(out[2].frames == 0);
      CHECK(out[3].frames == 0);
      if (k != 4) CHECK(out[1].w_static > 0.9);
      if (k == 4) CHECK(std::isnan(out[1].residual_px));
      if (k == 4) CHECK(std::isnan(out[1].w_static));
    }
    WatchedLines lost;
    for (int k = 0; k < 4; ++k) {
      const std::vector<LineSighting> seen{{kFirstImageLineId, ends_of(sideways(k), kPost)}};
      const Pose nowhere{Eigen::Quaterniond::Identity(), {nan, 0, 0}};
      CHECK(std::isnan(lost.show(nowhere, seen)[0].w_static));
    }
    // Without poses nobody knows.
    WatchedLines blind;
    for (int k = 0; k < 4; ++k) {
      const std::vector<LineSighting> seen{{kFirstImageLineId, ends_of(sideways(k), kPost)}};
      CHECK(std::isnan(blind.show(sideways(k), seen, {}, 0)[0].w_static));
    }
  }

  TEST_CASE("as many lines and points as there can be are judged") {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<Segment3> segments;
    std::vector<Vector3d> points;
    for (std::size_t i = 0; i < limits::kMaxLines; ++i) {
      const Vector3d at(1.5 * unit(random), unit(random), 3.0 + unit(random));
      segments.push_back({at, at + Vector3d(0.5 * unit(random), 0.5 * unit(random), 0.2)});
    }
    for (std::size_t i = 0; i < limits::kMaxPoints; ++i)
      points.emplace_back(1.5 * unit(random), unit(random), 3.0 + unit(random));
    WatchedLines watched;
    for (int k = 0; k < kFrames; ++k) {
      std::vector<LineSighting> lines;
      std::vector<Sighting> seen;
      for (std::size_t i = 0; i < segments.size(); ++i)
        lines.push_back(
            {kFirstImageLineId + static_cast<FeatureId>(i), ends_of(sideways(k), segments[i])});
      for (std::size_t i = 0; i < points.size(); ++i)
        seen.push_back(
            {static_cast<FeatureId>(i + 1), (sideways(k).inverse() * points[i]).hnormalized()});
      const auto out = watched.show(sideways(k), lines, seen);
      for (const LineMotionEvidence& e : out) CHECK((k == 0 || e.w_static > 0.8));
    }
  }
}

}  // namespace pled
