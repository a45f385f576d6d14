#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/geometry/line_triangulation.hpp"
#include "pled_vins/geometry/so3.hpp"

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using pled::Pose;

constexpr double kSigma_xy = 0.002;  // 0.4 px at f = 200 px
constexpr int kTrials = 1000;

// 0.8 m of a line, seen while flying 4 m along it.
const Vector3d kStart{-0.4, 0.4, 4.0}, kEnd{0.4, 0.4, 4.0};

Vector2d noisy(std::mt19937_64& random) {
  std::normal_distribution<double> noise(0.0, kSigma_xy);
  const double x = noise(random);
  return {x, noise(random)};
}

/// Eleven views, turned a little; from the first to the last they leave the plane of the first by
/// `leave_m`.
std::vector<pled::SegmentView> fly_along(std::mt19937_64& random, double leave_m) {
  const Vector3d out = leave_m / 10.0 * kStart.cross(kEnd).normalized();
  std::normal_distribution<double> turn(0.0, 0.05);
  std::vector<pled::SegmentView> views;
  for (int k = -5; k <= 5; ++k) {
    const double x = turn(random), y = turn(random);
    const Pose T_world_cam{pled::so3::exp({x, y, turn(random)}), k * (Vector3d(0.4, 0, 0) + out)};
    const Pose T = T_world_cam.inverse();
    const Vector2d start = (T * kStart).hnormalized() + noisy(random);
    views.push_back({T_world_cam, start, (T * kEnd).hnormalized() + noisy(random)});
  }
  return views;
}

/// Squared error of the worse of both inverse depths, in parts of the variance that is claimed.
double depth_nees(const pled::TriangulatedLine& got, const pled::SegmentView& reference) {
  const Pose T = reference.T_world_cam.inverse();
  const pled::PluckerLine truth = T * pled::line_through(kStart, kEnd);
  const auto start = pled::point_seen_at(truth, reference.start_xy);
  const auto end = pled::point_seen_at(truth, reference.end_xy);
  REQUIRE(start.has_value());
  REQUIRE(end.has_value());
  const double rho1 = 1.0 / (T * got.start_world).z(), rho2 = 1.0 / (T * got.end_world).z();
  const double error = std::max(std::abs(rho1 - 1.0 / start->z()), std::abs(rho2 - 1.0 / end->z()));
  return std::pow(error / (got.depth_sigma * std::max(rho1, rho2)), 2);
}

struct Tally {
  int accepted = 0;
  double nees = 0.0;

  [[nodiscard]] double mean_nees() const { return nees / accepted; }
};

Tally triangulate_many(double leave_m, double min_baseline_sigmas) {
  std::mt19937_64 random(31);
  Tally tally;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto views = fly_along(random, leave_m);
    const auto got = pled::triangulate_line(
        views, {.sigma_xy = kSigma_xy, .min_baseline_sigmas = min_baseline_sigmas});
    if (!got) continue;
    ++tally.accepted;
    tally.nees += depth_nees(*got, views[got->view]);
  }
  return tally;
}

constexpr double kDefault = pled::LineTriangulationRules{}.min_baseline_sigmas;
constexpr double kOff = 1e-9;

}  // namespace

TEST_SUITE("geometry.line_triangulation.baseline") {
  TEST_CASE("noise feigns a line to a camera that flies along it, unless it must leave the plane") {
    // The ends' noise stands for a baseline, and what follows from it is believed: neither
    // the uncertainty of depths nor the angle at the line refuses it.
    const Tally feigned = triangulate_many(0.0, kOff);
    MESSAGE("without the rule " << feigned.accepted << " of " << kTrials << " lines, NEES "
                                << feigned.mean_nees());
    CHECK(feigned.accepted > kTrials / 5);
    CHECK(feigned.mean_nees() > 3.0);
    CHECK(triangulate_many(0.0, kDefault).accepted <= kTrials / 500);
  }

  TEST_CASE("lines that the rule lets pass are as exact as they claim") {
    const Tally tally = triangulate_many(0.4, kDefault);
    MESSAGE(tally.accepted << " of " << kTrials << " lines, NEES " << tally.mean_nees());
    CHECK(tally.accepted > kTrials / 2);
    CHECK(tally.mean_nees() < 2.0);  // of the larger of two errors: between one and two
  }
}
