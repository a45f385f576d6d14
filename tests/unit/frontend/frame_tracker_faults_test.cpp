#include <limits>
#include <set>

#include <doctest/doctest.h>

#include "support/frontend/tracked_scene.hpp"

namespace pled {
namespace {

using support::GreyImage;
using support::pose_at;
using support::TrackedScene;

FrameView view_of(const GreyImage& image, std::int64_t t_us) {
  FrameView frame;
  frame.t = Timestamp{t_us};
  frame.stamp_ns = t_us * 1000;
  frame.image = image.view();
  return frame;
}

}  // namespace

TEST_SUITE("frontend.frame_tracker.faults") {
  TEST_CASE("points under something that came into view are not followed as if nothing happened") {
    TrackedScene scene(false);
    TrackedScene other(false, {}, 99);
    const Pose pose = pose_at(0, 0, -1);
    scene.show(pose);
    GreyImage covered = scene.render(pose);
    GreyImage cover = other.render(pose);
    for (int y = 40; y < 140; ++y)
      for (int x = 60; x < 180; ++x) covered.at(y, x) = cover.at(y, x);
    scene.show(pose, covered);
    int outside = 0;
    for (const PointMeasurement& p : scene.measured().points) {
      if (p.track_length < 2) continue;
      const bool well_inside =
          p.raw_px[0] > 68 && p.raw_px[0] < 172 && p.raw_px[1] > 48 && p.raw_px[1] < 132;
      const bool well_outside =
          p.raw_px[0] < 50 || p.raw_px[0] > 190 || p.raw_px[1] < 30 || p.raw_px[1] > 150;
      CHECK_FALSE((well_inside && p.inlier));
      if (well_outside) ++outside;
    }
    CHECK(outside >= 40);
    CHECK(scene.measured().lost >= 20);
  }

  TEST_CASE("a frame of another size is refused and the tracks go on after it") {
    TrackedScene scene(false);
    scene.show(pose_at(0, 0, -1));
    const GreyImage strange(120, 90);
    FrameMeasurement out;
    CHECK_FALSE(scene.tracker().track(view_of(strange, 20'000), Timestamp{20'000}, {}, out));
    CHECK(out.points.empty());
    CHECK(out.stamp_ns == 20'000'000);
    CHECK_FALSE(scene.tracker().track(FrameView{}, Timestamp{30'000}, {}, out));
    scene.show(pose_at(0.005, 0, -1));
    CHECK(scene.errors_px().size() >= 80);
  }

  TEST_CASE("black frames end all tracks, give no corners, and the next image starts afresh") {
    TrackedScene scene(false);
    scene.show(pose_at(0, 0, -1));
    const std::size_t before = scene.measured().points.size();
    FeatureId last = 0;
    for (const PointMeasurement& p : scene.measured().points) last = std::max(last, p.id);
    const GreyImage black(240, 180);
    scene.show(pose_at(0, 0, -1), black);
    CHECK(scene.measured().points.empty());
    CHECK(scene.measured().lost == before);
    scene.show(pose_at(0, 0, -1), black);
    scene.show(pose_at(0, 0, -1));
    CHECK(scene.measured().points.size() >= 80);
    for (const PointMeasurement& p : scene.measured().points) CHECK(p.id > last);
  }

  TEST_CASE("a frozen frame moves no point although the gyro turns") {
    TrackedScene scene(false);
    const GreyImage image = scene.render(pose_at(0, 0, -1));
    scene.show(pose_at(0, 0, -1), image);
    std::map<FeatureId, std::array<double, 2>> before;
    for (const PointMeasurement& p : scene.measured().points) before[p.id] = p.raw_px;
    scene.show(pose_at(0, 0, -1, {0, 0.01, 0}), image);
    int followed = 0;
    for (const PointMeasurement& p : scene.measured().points) {
      if (p.track_length < 2) continue;
      ++followed;
      CHECK(std::abs(p.raw_px[0] - before.at(p.id)[0]) < 0.05);
      CHECK(std::abs(p.raw_px[1] - before.at(p.id)[1]) < 0.05);
    }
    CHECK(followed >= 80);
  }

  TEST_CASE("without a rotation points are still followed, and none is called an outlier") {
    TrackedScene scene(false);
    scene.show(pose_at(0, 0, -1));
    const Pose moved = pose_at(0.012, 0, -1);
    scene.show(moved, scene.render(moved), false);
    CHECK(scene.errors_px().size() >= 80);
    CHECK(support::quantile(scene.errors_px(), 0.5) < 0.05);
    for (const PointMeasurement& p : scene.measured().points) CHECK(p.inlier);
  }

  TEST_CASE("a rotation that is not a number counts as unknown") {
    TrackedScene scene(false);
    scene.show(pose_at(0, 0, -1));
    const GreyImage image = scene.render(pose_at(0.003, 0, -1));
    FrameMeasurement out;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(scene.tracker().track(view_of(image, 50'000), Timestamp{50'000},
                                Eigen::Quaterniond(nan, nan, nan, nan), out));
    CHECK(out.points.size() >= 80);
    for (const PointMeasurement& p : out.points) CHECK(std::isfinite(p.bearing_xy[0]));
  }

  TEST_CASE("a jump to another place ends the tracks instead of inventing motion") {
    TrackedScene scene(false);
    scene.show(pose_at(0, 0, -1));
    const std::size_t before = scene.measured().points.size();
    scene.show(pose_at(3.0, 2.0, -1), scene.render(pose_at(3.0, 2.0, -1)), false);
    CHECK(scene.measured().lost >= before * 8 / 10);
    CHECK(scene.measured().points.size() >= 80);
  }

  TEST_CASE("ids are not used again after a reset") {
    TrackedScene scene(false);
    scene.show(pose_at(0, 0, -1));
    std::set<FeatureId> ids;
    for (const PointMeasurement& p : scene.measured().points) ids.insert(p.id);
    scene.tracker().reset();
    scene.show(pose_at(0, 0, -1));
    CHECK(scene.measured().points.size() == ids.size());
    for (const PointMeasurement& p : scene.measured().points) {
      CHECK(p.track_length == 1);
      CHECK(ids.count(p.id) == 0);
    }
  }
}

}  // namespace pled
