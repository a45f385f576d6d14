#include "pled_vins/geometry/triangulation.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using pled::BearingView;
using pled::Pose;
using pled::triangulate;

Vector3d random_vector(std::mt19937_64& random, double scale) {
  std::normal_distribution<double> normal;
  return scale * Vector3d(normal(random), normal(random), normal(random));
}

BearingView see(const Pose& T_world_cam, const Vector3d& p_world) {
  const Vector3d p = T_world_cam.inverse() * p_world;
  return {T_world_cam, p.head<2>() / p.z()};
}

/// Cameras near the origin of some frame that look along its z axis.
std::vector<Pose> cameras(std::mt19937_64& random, int n, double spread_m) {
  const Pose T_world_frame{pled::so3::exp(random_vector(random, 1.0)), random_vector(random, 20.0)};
  std::vector<Pose> out;
  for (int i = 0; i < n; ++i) {
    out.push_back(T_world_frame * Pose{pled::so3::exp(random_vector(random, 0.05)),
                                       random_vector(random, spread_m)});
  }
  return out;
}

std::vector<BearingView> views_of(const std::vector<Pose>& poses, const Vector3d& p_world) {
  std::vector<BearingView> out;
  for (const Pose& pose : poses) out.push_back(see(pose, p_world));
  return out;
}

double cost(const std::vector<BearingView>& views, const Vector3d& p_world) {
  double sum = 0.0;
  for (const BearingView& v : views) {
    sum += (see(v.T_world_cam, p_world).bearing_xy - v.bearing_xy).squaredNorm();
  }
  return sum;
}

}  // namespace

TEST_SUITE("geometry.triangulation") {
  TEST_CASE("exact bearings give the exact point, from 2 to 32 views, near and far") {
    std::mt19937_64 random(11);
    for (const int n : {2, 3, 8, 32}) {
      for (const double depth_m : {1.0, 5.0, 50.0}) {
        CAPTURE(n);
        CAPTURE(depth_m);
        const auto poses = cameras(random, n, 0.2);
        const Vector3d p = poses[0] * Vector3d(0.2 * depth_m, -0.1 * depth_m, depth_m);
        const auto views = views_of(poses, p);
        const std::size_t anchor = static_cast<std::size_t>(n) - 1;
        const auto got = triangulate(views, anchor);
        REQUIRE(got.has_value());
        CHECK((got->p_world - p).norm() < 1e-9 * depth_m * depth_m);
        CHECK(got->inverse_depth ==
              doctest::Approx(1.0 / (poses[anchor].inverse() * p).z()).epsilon(1e-8));
        CHECK(got->rms_error < 1e-12);
      }
    }
  }

  TEST_CASE("parallax is the largest angle between the rays at the point") {
    const std::vector<Pose> poses{Pose{}, Pose{Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0}},
                                  Pose{Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0}}};
    const auto got = triangulate(views_of(poses, {0.0, 0.0, 2.0}));
    REQUIRE(got.has_value());
    CHECK(got->parallax_rad == doctest::Approx(std::atan2(1.0, 2.0)).epsilon(1e-9));
  }

  TEST_CASE("with noise the point is a minimum of the reprojection error") {
    std::mt19937_64 random(12);
    std::normal_distribution<double> normal(0.0, 1.0 / 200.0);
    for (int trial = 0; trial < 20; ++trial) {
      const auto poses = cameras(random, 8, 0.3);
      auto views = views_of(poses, poses[0] * Vector3d(0.5, 0.3, 4.0));
      for (BearingView& v : views) v.bearing_xy += Vector2d(normal(random), normal(random));
      const auto got = triangulate(views);
      REQUIRE(got.has_value());
      const double least = cost(views, got->p_world);
      CHECK(got->rms_error == doctest::Approx(std::sqrt(least / 8.0)).epsilon(1e-9));
      for (int k = 0; k < 3; ++k) {
        for (const double step_m : {-1e-3, 1e-3}) {
          CHECK(cost(views, got->p_world + step_m * Vector3d::Unit(k)) > least);
        }
      }
    }
  }

  TEST_CASE("a far point with noise keeps its bearing") {
    std::mt19937_64 random(13);
    std::normal_distribution<double> normal(0.0, 1e-3);
    int solved = 0;
    for (int trial = 0; trial < 50; ++trial) {
      const auto poses = cameras(random, 10, 0.5);
      auto views = views_of(poses, poses[0] * Vector3d(0.0, 0.0, 60.0));
      for (BearingView& v : views) v.bearing_xy += Vector2d(normal(random), normal(random));
      const auto got = triangulate(views);
      if (!got) continue;  // noise can put the best point behind the cameras
      ++solved;
      CHECK(got->rms_error < 3e-3);
      CHECK((see(poses[0], got->p_world).bearing_xy).norm() < 5e-3);
    }
    CHECK(solved > 25);
  }

  TEST_CASE("a point behind a camera is refused") {
    const std::vector<Pose> poses{Pose{}, Pose{Eigen::Quaterniond::Identity(), {0.5, 0.0, 0.0}}};
    // Diverging rays meet at (0.25, 0, -0.5), behind both.
    const std::vector<BearingView> views{{poses[0], {-0.5, 0.0}}, {poses[1], {0.5, 0.0}}};
    CHECK_FALSE(triangulate(views).has_value());
  }

  TEST_CASE("cameras in one place and parallel rays are refused") {
    const Pose turned{pled::so3::exp({0.0, 0.1, 0.0}), Vector3d::Zero()};
    CHECK_FALSE(triangulate(views_of({Pose{}, turned}, {0.1, 0.2, 3.0})).has_value());
    auto noisy = views_of({Pose{}, turned}, {0.1, 0.2, 3.0});
    noisy[0].bearing_xy.x() += 0.005;  // seeming parallax without a baseline
    CHECK_FALSE(triangulate(noisy).has_value());
    const Pose beside{Eigen::Quaterniond::Identity(), {0.5, 0.0, 0.0}};
    const std::vector<BearingView> parallel{{Pose{}, {0.1, 0.2}}, {beside, {0.1, 0.2}}};
    CHECK_FALSE(triangulate(parallel).has_value());
  }

  TEST_CASE("too few or too many views, a wrong anchor and NaN are refused") {
    const std::vector<BearingView> one{{Pose{}, {0.0, 0.0}}};
    CHECK_FALSE(triangulate(one).has_value());
    std::mt19937_64 random(14);
    const auto poses = cameras(random, 33, 0.2);
    const auto many = views_of(poses, poses[0] * Vector3d(0.0, 0.0, 3.0));
    CHECK_FALSE(triangulate(many).has_value());
    auto two = std::vector<BearingView>(many.begin(), many.begin() + 2);
    CHECK(triangulate(two).has_value());
    CHECK_FALSE(triangulate(two, 2).has_value());
    two[1].bearing_xy.x() = std::numeric_limits<double>::quiet_NaN();
    CHECK_FALSE(triangulate(two).has_value());
  }
}
