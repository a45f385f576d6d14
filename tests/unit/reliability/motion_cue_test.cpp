#include "pled_vins/reliability/motion_cue.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"
#include "support/reliability/watched_points.hpp"

namespace pled {
namespace {

using namespace support;

/// Frames 0 ... `last` of points that move in the world by `step_m` a frame; the last's evidence.
MotionEvidence evidence_of_mover(const Eigen::Vector3d& start, const Eigen::Vector3d& step_m,
                                 int last, const MotionCueConfig& config = {}) {
  WatchedPoints watched(one_camera_rig(), config);
  MotionEvidence out;
  for (int k = 0; k <= last; ++k) {
    const Sighting s{1, watched.bearing(sideways(k), start + k * step_m)};
    out = watched.show(sideways(k), {&s, 1})[0];
  }
  return out;
}

/// Root of the mean square of 1 ... n.
double rms_up_to(int n) {
  double squares = 0.0;
  for (int k = 1; k <= n; ++k) squares += k * k;
  return std::sqrt(squares / n);
}

/// w_static of a point nobody is near, from its residual.
double weight_alone(double residual_px, const MotionCueConfig& c) {
  const double belief = c.own_weight * std::log(residual_px / c.even_px) / (c.own_weight + 0.05);
  return 1.0 / (1.0 + std::exp(c.steepness * belief));
}

}  // namespace

TEST_SUITE("reliability.motion_cue") {
  TEST_CASE("points at rest have no residual and their own depth, from 0.3 m to infinity") {
    WatchedPoints watched(one_camera_rig());
    const auto pose = [](int k) {
      return Pose{so3::exp({0.02 * k, -0.03 * k, 0.01 * k}), {0.01 * k, -0.006 * k, 0.008 * k}};
    };
    constexpr int kLast = 6;
    const std::vector<double> depths{0.3, 0.5, 1.0, 4.0, 60.0, 1e9};
    std::vector<Eigen::Vector3d> points;
    for (std::size_t i = 0; i < depths.size(); ++i)  // depth in the last frame's camera
      points.push_back(pose(kLast) *
                       (depths[i] * Eigen::Vector3d(0.1 * static_cast<double>(i) - 0.2, 0.1, 1.0)));
    std::span<const MotionEvidence> out;
    for (int k = 0; k <= kLast; ++k) {
      std::vector<Sighting> seen;
      for (std::size_t i = 0; i < points.size(); ++i)
        seen.push_back({static_cast<FeatureId>(i + 1), watched.bearing(pose(k), points[i])});
      out = watched.show(pose(k), seen);
    }
    for (std::size_t i = 0; i < depths.size(); ++i) {
      CAPTURE(depths[i]);
      CHECK(out[i].frames == kLast);
      CHECK(out[i].residual_px < 1e-6);
      CHECK(out[i].inverse_depth_pm == doctest::Approx(1.0 / depths[i]).epsilon(1e-6));
      CHECK(out[i].w_static > 0.98);  // the nearest stands out a little
    }
  }

  TEST_CASE("what moves across its epipolar line is left over, frame by frame") {
    constexpr double kAcross_m = 0.01;
    const MotionEvidence e = evidence_of_mover({0, 0, 2}, {0, kAcross_m, 0}, 3);
    CHECK(e.frames == 3);
    CHECK(e.residual_px == doctest::Approx(kFocal_px * kAcross_m / 2.0 * rms_up_to(3)));
    CHECK(e.w_static < 0.5);
  }

  TEST_CASE("what moves along its epipolar line as another depth would is not seen to move") {
    // A camera that goes b sees one that goes m at depth z as one at rest at z b / (b - m).
    constexpr double kAlong_m = 0.02;
    const MotionEvidence e = evidence_of_mover({0.1, 0, 2}, {kAlong_m, 0, 0}, 4);
    CHECK(e.residual_px < 1e-6);
    CHECK(e.inverse_depth_pm == doctest::Approx((kStep_m - kAlong_m) / (kStep_m * 2.0)));
    CHECK(e.w_static > 0.9);
  }

  TEST_CASE("what only a negative depth would explain is left over") {
    constexpr double kAlong_m = 0.08;  // overtakes the camera
    const MotionEvidence e = evidence_of_mover({0.1, 0, 2}, {kAlong_m, 0, 0}, 4);
    CHECK(e.inverse_depth_pm == 0.0);
    CHECK(e.residual_px == doctest::Approx(kFocal_px * (kAlong_m - kStep_m) / 2.0 * rms_up_to(4)));
    CHECK(e.w_static < 0.2);
  }

  TEST_CASE("the larger the residual the smaller the weight, one half at even_px") {
    MotionCueConfig config;
    double last_w = 1.0;
    for (const double residual_px : {0.06, 0.2, 0.5, 0.89, 0.91, 2.0, 6.0, 19.0}) {
      const MotionEvidence e =
          evidence_of_mover({0, 0, 1}, {0, residual_px / kFocal_px, 0}, 1, config);
      CAPTURE(residual_px);
      CHECK(e.residual_px == doctest::Approx(residual_px));
      CHECK(e.w_static == doctest::Approx(weight_alone(residual_px, config)));
      CHECK(e.w_static < last_w);
      last_w = e.w_static;
    }
    config.even_px = 3.0;
    CHECK(evidence_of_mover({0, 0, 1}, {0, 3.0 / kFocal_px, 0}, 1, config).w_static ==
          doctest::Approx(0.5));
  }

  TEST_CASE("beyond what a track can be wrong by, more residual says no more") {
    const auto w = [](double px) {
      return evidence_of_mover({0, 0, 1}, {0, px / kFocal_px, 0}, 1).w_static;
    };
    CHECK(w(40.0) == w(30.0));
    CHECK(w(0.0) == w(0.01));
  }

  TEST_CASE("a new point is believed to do what those beside it do; far from all it has none") {
    WatchedPoints watched(one_camera_rig());
    std::span<const MotionEvidence> out;
    constexpr int kLast = 3;
    for (int k = 0; k <= kLast; ++k) {
      // The camera stands. Points 1 to 3 move by 5 px a frame at the left, 4 and 5 rest at the
      // right.
      const double step = 5.0 / kFocal_px;
      std::vector<Sighting> seen{{1, {-0.30, -0.1 + step * k}},
                                 {2, {-0.28, -0.1 + step * k}},
                                 {3, {-0.29, -0.08 + step * k}},
                                 {4, {0.3, 0.0}},
                                 {5, {0.32, 0.0}}};
      if (k == kLast) {
        seen.push_back({6, {-0.29, -0.09 + step * k}});
        seen.push_back({7, {0.31, 0.01}});
        seen.push_back({8, {0.0, 0.4}});
      }
      out = watched.show({}, seen);
    }
    CHECK(out[0].w_static < 0.1);
    CHECK(out[5].w_static < 0.1);
    CHECK(out[5].frames == 0);
    CHECK(std::isnan(out[5].residual_px));
    CHECK(std::isnan(out[5].inverse_depth_pm));
    CHECK(out[6].w_static > 0.9);
    CHECK(std::isnan(out[7].w_static));
    CHECK(std::isnan(out[7].residual_px));
  }

  TEST_CASE("many neighbours outvote one bad track") {
    WatchedPoints watched(one_camera_rig());
    std::span<const MotionEvidence> out;
    for (int k = 0; k < 2; ++k) {
      std::vector<Sighting> seen{{1, {0.0, 0.01 * k}}};  // 2 px
      for (int i = 0; i < 12; ++i)
        seen.push_back(
            {static_cast<FeatureId>(i + 2), {0.01 * std::cos(i * 0.5), 0.01 * std::sin(i * 0.5)}});
      out = watched.show({}, seen);
    }
    CHECK(out[0].residual_px == doctest::Approx(2.0));
    CHECK(out[0].w_static > 0.5);
  }

  TEST_CASE("the order of the points and gaps in their ids make no difference") {
    std::mt19937_64 random(5);
    WatchedPoints in_order(one_camera_rig());
    WatchedPoints shuffled(one_camera_rig());
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<Eigen::Vector3d> points, speeds;
    std::vector<FeatureId> ids;
    for (FeatureId i = 0; i < 40; ++i) {
      points.push_back({unit(random), unit(random), 3.0 + unit(random)});
      speeds.push_back(i % 4 == 0 ? Eigen::Vector3d(0, 0.03, 0) : Eigen::Vector3d::Zero());
      ids.push_back(i < 20 ? 7 * i + 3 : 0x8000'0000U + 1000 * i);
    }
    for (int k = 0; k < 6; ++k) {
      std::vector<Sighting> seen;
      for (std::size_t i = 0; i < ids.size(); ++i)
        seen.push_back({ids[i], in_order.bearing(sideways(k), points[i] + k * speeds[i])});
      std::vector<std::size_t> order(seen.size());
      for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
      std::shuffle(order.begin(), order.end(), random);
      std::vector<Sighting> mixed;
      for (const std::size_t i : order) mixed.push_back(seen[i]);
      const auto a = in_order.show(sideways(k), seen);
      const auto b = shuffled.show(sideways(k), mixed);
      for (std::size_t i = 0; i < order.size(); ++i) {
        CHECK(b[i].frames == a[order[i]].frames);
        if (k == 0) continue;
        CHECK(b[i].residual_px == doctest::Approx(a[order[i]].residual_px).epsilon(1e-9));
        CHECK(b[i].w_static == doctest::Approx(a[order[i]].w_static).epsilon(1e-9));
      }
    }
  }

  TEST_CASE("tracks that end leave the others alone, and a hole ends what is known") {
    WatchedPoints watched(one_camera_rig());
    for (int k = 0; k < 4; ++k) {
      std::vector<Sighting> seen;
      for (const FeatureId id : {1U, 2U, 3U, 4U}) {
        if (id == 1 && k >= 2) continue;  // ends
        if (id == 3 && k == 2) continue;  // is away for a frame, and jumps meanwhile
        const double y = id == 3 && k < 2 ? 0.3 : 0.1 * id;
        seen.push_back({id, watched.bearing(sideways(k), {0.1 * id, y, 2})});
      }
      const auto out = watched.show(sideways(k), seen);
      if (k < 3) continue;
      REQUIRE(out.size() == 3);
      CHECK(out[0].frames == 3);
      CHECK(out[0].residual_px < 1e-6);
      CHECK(out[1].frames == 0);
      CHECK(out[2].frames == 3);
      CHECK(out[2].inverse_depth_pm == doctest::Approx(0.5));
    }
  }

  TEST_CASE("it looks back on so many frames and no further") {
    WatchedPoints watched(one_camera_rig());
    constexpr int kFrames = static_cast<int>(limits::kCueFrames);
    for (int k = 0; k < kFrames + 4; ++k) {
      const auto times = watched.cue().times(watched.next_time());
      REQUIRE(times.size() == static_cast<std::size_t>(std::min(k, kFrames)) + 1);
      for (std::size_t i = 0; i < times.size(); ++i)
        CHECK(times[i] == watched.next_time() - Duration{static_cast<std::int64_t>(i) * 50'000});
      const double jump = k == 0 ? 0.2 : 0.0;  // in frame 0 it was somewhere else
      const Sighting s{9, watched.bearing(sideways(k), {0.1, jump, 2})};
      const MotionEvidence e = watched.show(sideways(k), {&s, 1})[0];
      CAPTURE(k);
      CHECK(e.frames == std::min(k, kFrames));
      if (k >= 1) CHECK((e.residual_px > 1.0) == (k <= kFrames));
    }
  }

  TEST_CASE("only frames with a pose count, and without poses nobody has evidence") {
    const Eigen::Vector3d place(0.1, 0.05, 2);
    for (const std::size_t poses : {0U, 1U, 2U, 4U, 7U}) {
      WatchedPoints watched(one_camera_rig());
      MotionEvidence e;
      for (int k = 0; k < 7; ++k) {
        const Sighting s{1, watched.bearing(sideways(k), place)};
        e = watched.show(sideways(k), {&s, 1}, poses)[0];
      }
      CAPTURE(poses);
      CHECK(e.frames == (poses == 0 ? 0 : poses - 1));
      CHECK(std::isnan(e.w_static) == (poses < 2));
      CHECK(std::isnan(e.residual_px) == (poses < 2));
      if (poses >= 2) CHECK(e.inverse_depth_pm == doctest::Approx(0.5));
    }
  }

  TEST_CASE("a frame without poses is kept for later ones") {
    WatchedPoints watched(one_camera_rig());
    for (int k = 0; k < 3; ++k) {
      const Sighting s{1, watched.bearing(sideways(k), {0, 0, 2})};
      const auto out = watched.show(sideways(k), {&s, 1}, k < 2 ? 0 : 3);
      if (k == 2) CHECK(out[0].frames == 2);
    }
  }

  TEST_CASE("after reset() nothing is known") {
    WatchedPoints watched(one_camera_rig());
    const Sighting s{1, {0.1, 0.1}};
    for (int k = 0; k < 3; ++k) (void)watched.show({}, {&s, 1});
    watched.cue().reset();
    CHECK(watched.cue().times(watched.next_time()).size() == 1);
    const auto out = watched.show({}, {&s, 1});
    CHECK(out[0].frames == 0);
    CHECK(std::isnan(out[0].w_static));
    CHECK(watched.show({}, {&s, 1})[0].frames == 1);
  }

  TEST_CASE("points of two cameras speak for each other where they look at one place") {
    RigCalibration rig = one_camera_rig();
    rig.num_cameras = 2;
    rig.cameras[1] = support::pinhole_200();
    rig.cameras[1].fx_px = rig.cameras[1].fy_px = 400.0;
    rig.cameras[1].T_body_cam = {so3::exp({0.05, -0.3, 0.6}), {0.2, 0.1, -0.05}};
    WatchedPoints watched(rig);
    std::span<const MotionEvidence> out;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d moving(0.6, 0.06 * k, 4.0);
      const Eigen::Vector3d resting(-0.6, 0.0, 4.0);
      std::vector<Sighting> seen;
      for (const FeatureId id : {1U, 2U}) {
        const Eigen::Vector3d apart(0.02 * id, 0, 0);
        seen.push_back({id, watched.bearing({}, moving + apart, 0), 0});
        seen.push_back({id + 10, watched.bearing({}, resting + apart, 1), 1});
      }
      if (k == 2) {
        // Nobody knows how far new points are: their ray counts as that of an infinite distance.
        seen.push_back({20, watched.bearing({}, 1e6 * moving, 1), 1});
        seen.push_back({21, watched.bearing({}, 1e6 * resting, 0), 0});
      }
      out = watched.show({}, seen);
    }
    CHECK(out[0].residual_px > 2.0);
    CHECK(out[1].residual_px < 1e-6);
    CHECK(out[4].frames == 0);
    CHECK(out[4].w_static < 0.3);  // beside the movers of the other camera
    CHECK(out[5].w_static > 0.7);  // beside those at rest
  }

  TEST_CASE("a residual is in pixels of the camera that saw the point") {
    RigCalibration rig = one_camera_rig();
    rig.num_cameras = 2;
    rig.cameras[1] = support::pinhole_200();
    rig.cameras[1].fx_px = 380.0;
    rig.cameras[1].fy_px = 420.0;
    WatchedPoints watched(rig);
    std::span<const MotionEvidence> out;
    for (int k = 0; k < 2; ++k) {
      const std::vector<Sighting> seen{{1, {0.0, 0.01 * k}, 0}, {2, {0.0, 0.01 * k}, 1}};
      out = watched.show({}, seen);
    }
    CHECK(out[0].residual_px == doctest::Approx(2.0));
    CHECK(out[1].residual_px == doctest::Approx(4.0));
  }
}

}  // namespace pled
