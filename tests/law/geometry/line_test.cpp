#include "pled_vins/geometry/line.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using pled::LineTangent;
using pled::OrthonormalLine;
using pled::PluckerLine;
using pled::Pose;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
using Vector6d = Eigen::Matrix<double, 6, 1>;

Vector3d random_vector(std::mt19937_64& random, double scale) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random), z = normal(random);
  return scale * Vector3d(x, y, z);
}

Pose random_pose(std::mt19937_64& random) {
  const Vector3d turn = random_vector(random, 1.5);
  return {pled::so3::exp(turn), random_vector(random, 5.0)};
}

Vector6d unit(const PluckerLine& line) {
  Vector6d v;
  v << line.n, line.d;
  return v.normalized();
}

/// How far two lines differ, whatever their factors: 0 for the same.
double difference(const PluckerLine& a, const PluckerLine& b) {
  return std::min((unit(a) - unit(b)).norm(), (unit(a) + unit(b)).norm());
}

/// A line at `distance_m` from the origin, its direction of unit length.
PluckerLine random_line(std::mt19937_64& random, double distance_m) {
  const Vector3d d = random_vector(random, 1.0).normalized();
  const Vector3d x = distance_m * d.cross(random_vector(random, 1.0)).normalized();
  return {x.cross(d), d};
}

}  // namespace

TEST_SUITE("geometry.line") {
  TEST_CASE("both points of a line lie on it and its distance is |n| / |d|") {
    std::mt19937_64 random(1);
    for (int i = 0; i < 1000; ++i) {
      const Vector3d a = random_vector(random, 5.0), b = random_vector(random, 5.0);
      const PluckerLine line = pled::line_through(a, b);
      CHECK((a.cross(line.d) - line.n).norm() < 1e-12);
      CHECK((b.cross(line.d) - line.n).norm() < 1e-12);
      CHECK(std::abs(line.n.dot(line.d)) < 1e-12);
      const auto foot = pled::nearest_point(line, Vector3d::Zero());
      REQUIRE(foot.has_value());
      CHECK(foot->norm() == doctest::Approx(line.n.norm() / line.d.norm()).epsilon(1e-9));
    }
  }

  TEST_CASE("a moved line is the line through the moved points, and moving back restores it") {
    std::mt19937_64 random(2);
    for (int i = 0; i < 1000; ++i) {
      const Vector3d a = random_vector(random, 5.0), b = random_vector(random, 5.0);
      const Pose T = random_pose(random);
      const PluckerLine line = pled::line_through(a, b);
      const PluckerLine moved = T * line;
      CHECK(difference(moved, pled::line_through(T * a, T * b)) < 1e-12);
      CHECK(difference(T.inverse() * moved, line) < 1e-12);
    }
  }

  TEST_CASE("four numbers hold a line at any distance, the origin and infinity included") {
    std::mt19937_64 random(3);
    for (const double distance_m : {0.0, 1e-12, 1e-6, 0.1, 1.0, 10.0, 1e4, 1e9}) {
      CAPTURE(distance_m);
      for (int i = 0; i < 200; ++i) {
        const PluckerLine line = random_line(random, distance_m);
        const auto held = pled::to_orthonormal(line);
        REQUIRE(held.has_value());
        CHECK(std::tan(held->phi_rad) * distance_m ==
              doctest::Approx(distance_m > 1e-13 ? 1.0 : 0.0).epsilon(1e-3));
        const PluckerLine back = pled::to_plucker(*held);
        CHECK(difference(back, line) < 1e-14);
        CHECK(std::abs(back.n.dot(back.d)) < 1e-15);
        const auto again = pled::to_orthonormal(back);
        REQUIRE(again.has_value());
        CHECK(difference(pled::to_plucker(*again), line) < 1e-14);
      }
    }
    const auto horizon = pled::to_orthonormal({Vector3d(0, 3, 0), Vector3d::Zero()});
    REQUIRE(horizon.has_value());
    CHECK(pled::to_plucker(*horizon).d.norm() == 0.0);
    CHECK((pled::to_plucker(*horizon).n - Vector3d::UnitY()).norm() < 1e-15);
  }

  TEST_CASE("what is no line has no four numbers") {
    const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), none = Vector3d::Zero();
    CHECK_FALSE(pled::to_orthonormal({none, none}).has_value());
    CHECK_FALSE(pled::to_orthonormal({x, x}).has_value());
    CHECK_FALSE(pled::to_orthonormal({x, y + 1e-5 * x}).has_value());
    CHECK(pled::to_orthonormal({x, y + 1e-9 * x}).has_value());
    for (int k = 0; k < 3; ++k) {
      for (const double bad : {kNan, std::numeric_limits<double>::infinity()}) {
        PluckerLine line{x, y};
        line.n[k] = bad;
        CHECK_FALSE(pled::to_orthonormal(line).has_value());
        line = {x, y};
        line.d[k] = bad;
        CHECK_FALSE(pled::to_orthonormal(line).has_value());
      }
    }
  }

  TEST_CASE("every step stays a line, and the step between two lines leads from one to the other") {
    std::mt19937_64 random(4);
    for (int i = 0; i < 1000; ++i) {
      const auto from = pled::to_orthonormal(random_line(random, std::pow(10.0, i % 5 - 2)));
      REQUIRE(from.has_value());
      LineTangent delta;
      delta << random_vector(random, 0.5), random_vector(random, 0.5).x();
      const OrthonormalLine to = pled::box_plus(*from, delta);
      const PluckerLine line = pled::to_plucker(to);
      CHECK(std::abs(line.n.dot(line.d)) < 1e-15);
      CHECK((pled::box_minus(to, *from) - delta).norm() < 1e-12);
      CHECK(difference(pled::to_plucker(pled::box_plus(*from, pled::box_minus(to, *from))), line) <
            1e-13);
    }
  }

  TEST_CASE("a step over infinity comes back from the other side") {
    const auto far =
        pled::to_orthonormal(pled::line_through(Vector3d(-1, 0, 1e3), Vector3d(1, 0, 1e3)));
    REQUIRE(far.has_value());
    const OrthonormalLine beyond = pled::box_plus(*far, LineTangent(0, 0, 0, -2 * far->phi_rad));
    const auto foot = pled::nearest_point(pled::to_plucker(beyond), Vector3d::Zero());
    REQUIRE(foot.has_value());
    CHECK((*foot - Vector3d(0, 0, -1e3)).norm() < 1e-9);
  }

  TEST_CASE("the Jacobian of n and d equals central differences in 10000 states") {
    // Near-degenerate: one in eight within 1 mm of the origin, one in eight beyond 10 km.
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> exponent(-1.0, 2.0);
    double worst = 0.0;
    for (int i = 0; i < 10000; ++i) {
      double distance_m = std::pow(10.0, exponent(random));
      if (i % 8 == 0) distance_m *= 1e-4;
      if (i % 8 == 1) distance_m *= 1e5;
      const auto line = pled::to_orthonormal(random_line(random, distance_m));
      REQUIRE(line.has_value());
      const Eigen::Matrix<double, 6, 4> J = pled::plucker_jacobian(*line);
      Eigen::Matrix<double, 6, 4> numeric;
      constexpr double kStep = 1e-5;
      for (int k = 0; k < 4; ++k) {
        LineTangent h = LineTangent::Zero();
        h[k] = kStep;
        const PluckerLine plus = pled::to_plucker(pled::box_plus(*line, h));
        const PluckerLine minus = pled::to_plucker(pled::box_plus(*line, -h));
        numeric.col(k) << plus.n - minus.n, plus.d - minus.d;
      }
      worst = std::max(worst, (numeric / (2 * kStep) - J).norm() / J.norm());
    }
    CHECK(worst < 1e-6);
    MESSAGE("worst relative difference " << worst);
  }

  TEST_CASE("the picture of a line holds the pictures of its points") {
    std::mt19937_64 random(6);
    for (int i = 0; i < 1000; ++i) {
      const Vector3d a = random_vector(random, 1.0) + Vector3d(0, 0, 6);
      const Vector3d b = random_vector(random, 1.0) + Vector3d(0, 0, 6);
      const Vector2d seen = a.head<2>() / a.z();
      const auto l = pled::project(pled::line_through(a, b));
      REQUIRE(l.has_value());
      CHECK(l->head<2>().norm() == doctest::Approx(1.0).epsilon(1e-14));
      CHECK(std::abs(l->dot(seen.homogeneous())) < 1e-12);
      const Vector2d aside = seen + 0.1 * l->head<2>();
      CHECK(l->dot(aside.homogeneous()) == doctest::Approx(0.1).epsilon(1e-10));
    }
  }

  TEST_CASE("a line through the camera, in its plane z = 0, or of NaN has no picture") {
    CHECK_FALSE(pled::project(pled::line_through({0, 0, 1}, {0, 0, 5})).has_value());
    CHECK_FALSE(pled::project(pled::line_through({0, 1, 0}, {1, 1, 0})).has_value());
    CHECK_FALSE(pled::project({Vector3d(kNan, 1, 0), Vector3d::UnitZ()}).has_value());
    CHECK_FALSE(pled::project({Vector3d(1, kNan, 0), Vector3d::UnitZ()}).has_value());
    CHECK_FALSE(pled::project({Vector3d(1, 0, kNan), Vector3d::UnitY()}).has_value());
    CHECK_FALSE(pled::project({Vector3d::UnitX(), Vector3d(0, kNan, 0)}).has_value());
  }

  TEST_CASE(
      "ends in the picture give back the ends in space, offsets across the line change nothing") {
    std::mt19937_64 random(7);
    for (int i = 0; i < 1000; ++i) {
      const Vector3d a = random_vector(random, 1.0) + Vector3d(0, 0, 6);
      const Vector3d b = random_vector(random, 1.0) + Vector3d(0, 0, 6);
      const PluckerLine line = pled::line_through(a, b);
      const auto l = pled::project(line);
      REQUIRE(l.has_value());
      const Vector2d seen = a.head<2>() / a.z();
      for (const double aside : {0.0, 0.01, -0.3}) {
        const auto end = pled::point_seen_at(line, seen + aside * l->head<2>());
        REQUIRE(end.has_value());
        CHECK((*end - a).norm() < 1e-6);
      }
    }
  }

  TEST_CASE("an end behind the camera, on a line seen end on, or of NaN is refused") {
    const PluckerLine behind = pled::line_through({-1, 0.5, -3}, {1, 0.5, -3});
    CHECK(pled::project(behind).has_value());
    CHECK_FALSE(pled::point_seen_at(behind, {0.0, -0.1}).has_value());
    const PluckerLine wall = pled::line_through({-1, 0.5, 3}, {1, 0.5, 3});
    CHECK(pled::point_seen_at(wall, {0.0, 0.1}).has_value());
    CHECK_FALSE(pled::point_seen_at(wall, {kNan, 0.1}).has_value());
    CHECK_FALSE(pled::point_seen_at(wall, {0.1, kNan}).has_value());
    // A line along z has its vanishing point at (0, 0): nothing of it is seen there.
    const PluckerLine lane = pled::line_through({0, 1, 2}, {0, 1, 9});
    CHECK_FALSE(pled::point_seen_at(lane, {0.0, 0.0}).has_value());
    CHECK_FALSE(pled::point_seen_at(lane, {0.0, -0.2}).has_value());  // beyond it: behind
    CHECK(pled::point_seen_at(lane, {0.0, 0.2}).has_value());
  }

  TEST_CASE(
      "the nearest points of a point and a line, and of two lines, are nearer than any beside") {
    std::mt19937_64 random(8);
    for (int i = 0; i < 200; ++i) {
      const PluckerLine a = random_line(random, 3.0), b = random_line(random, 2.0);
      const Vector3d p = random_vector(random, 4.0);
      const auto x = pled::nearest_point(a, p);
      REQUIRE(x.has_value());
      CHECK((x->cross(a.d) - a.n).norm() < 1e-12);
      CHECK(std::abs((*x - p).dot(a.d)) < 1e-12);
      const auto pair = pled::nearest_points(a, b);
      REQUIRE(pair.has_value());
      const double sine = a.d.cross(b.d).norm();
      CHECK((pair->on_a.cross(a.d) - a.n).norm() < 1e-12 / (sine * sine));
      CHECK((pair->on_b.cross(b.d) - b.n).norm() < 1e-12 / (sine * sine));
      const Vector3d between = pair->on_a - pair->on_b;
      CHECK(std::abs(between.dot(a.d)) < 1e-12 / (sine * sine));
      CHECK(std::abs(between.dot(b.d)) < 1e-12 / (sine * sine));
    }
    const PluckerLine line = pled::line_through({0, 1, 0}, {1, 1, 0});
    const PluckerLine parallel = pled::line_through({0, 0, 2}, {5, 0, 2});
    CHECK_FALSE(pled::nearest_points(line, parallel).has_value());
    CHECK_FALSE(pled::nearest_points(line, {Vector3d(kNan, 0, 0), Vector3d::UnitY()}).has_value());
    CHECK_FALSE(pled::nearest_point({Vector3d::UnitX(), Vector3d::Zero()}, {1, 2, 3}).has_value());
    CHECK_FALSE(pled::nearest_point(line, {kNan, 2, 3}).has_value());
  }
}
