#include "pled_vins/frontend/motion_check.hpp"

#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"
#include "support/frontend/plane_scene.hpp"

namespace pled {
namespace {

constexpr double kFocal = 199.0;
constexpr double kGate = 1.5;
constexpr std::size_t kPairs = 100;

/// Points 2 ... 8 m away seen from two poses, the first `moving` of which moved in between.
std::vector<BearingPair> pairs_of(const Eigen::Matrix3d& R, const Eigen::Vector3d& t,
                                  std::size_t moving, const Eigen::Vector3d& motion,
                                  double noise_px, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<BearingPair> pairs;
  for (std::size_t i = 0; i < kPairs; ++i) {
    const double depth = 2.0 + 6.0 * support::uniform(random);
    const Eigen::Vector3d from(depth * (1.2 * support::uniform(random) - 0.6),
                               depth * (0.9 * support::uniform(random) - 0.45), depth);
    Eigen::Vector3d to = R * from + t;
    if (i < moving) to += motion;
    const auto noise = [&] { return noise_px / kFocal * support::normal(random); };
    pairs.push_back({from.x() / from.z() + noise(), from.y() / from.z() + noise(),
                     to.x() / to.z() + noise(), to.y() / to.z() + noise()});
  }
  return pairs;
}

}  // namespace

TEST_SUITE("frontend.motion_check") {
  const Eigen::Matrix3d R = so3::exp({0.02, -0.05, 0.1}).toRotationMatrix();

  TEST_CASE("40 % of the points that move alike are told from the scene") {
    const Eigen::Vector3d t(0.3, 0.05, 0.1);
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
      CAPTURE(seed);
      const auto pairs = pairs_of(R, t, 40, {0.0, 0.35, 0.0}, 0.1, seed);
      MotionCheck check(kFocal, kGate);
      std::vector<MotionVerdict> verdicts(kPairs);
      const MotionEstimate estimate = check.judge(R, pairs, verdicts);
      CHECK(estimate.translating);
      CHECK(estimate.direction.dot(t.normalized()) > 0.99);
      for (std::size_t i = 0; i < kPairs; ++i) {
        CAPTURE(i);
        CHECK(verdicts[i].inlier == (i >= 40));
      }
    }
  }

  TEST_CASE("points that slide along their epipolar lines the wrong way are outliers") {
    const Eigen::Vector3d t(0.3, 0.0, 0.0);
    const auto pairs = pairs_of(R, t, 20, -2.5 * t, 0.05, 7);
    MotionCheck check(kFocal, kGate);
    std::vector<MotionVerdict> verdicts(kPairs);
    (void)check.judge(R, pairs, verdicts);
    for (std::size_t i = 0; i < kPairs; ++i) {
      CAPTURE(i);
      CHECK(verdicts[i].inlier == (i >= 20));
    }
  }

  TEST_CASE("while the camera only turns, what moves is an outlier, whatever way it goes") {
    const auto pairs = pairs_of(R, Eigen::Vector3d::Zero(), 30, {0.3, 0.0, 0.0}, 0.1, 3);
    MotionCheck check(kFocal, kGate);
    std::vector<MotionVerdict> verdicts(kPairs);
    const MotionEstimate estimate = check.judge(R, pairs, verdicts);
    CHECK_FALSE(estimate.translating);
    CHECK(estimate.median_parallax_px < 1.0);
    for (std::size_t i = 0; i < kPairs; ++i) {
      CAPTURE(i);
      CHECK(verdicts[i].inlier == (i >= 30));
    }
  }

  TEST_CASE("too few points to vote are all believed") {
    const auto pairs = pairs_of(R, {0.3, 0, 0}, 3, {0, 1, 0}, 0.1, 3);
    MotionCheck check(kFocal, kGate);
    std::vector<MotionVerdict> verdicts(7, MotionVerdict{false, -1.0});
    (void)check.judge(R, std::span(pairs).first(7), verdicts);
    for (const MotionVerdict& v : verdicts) CHECK(v.inlier);
    CHECK(check.judge(R, {}, {}).median_parallax_px == 0.0);
  }
}

}  // namespace pled
