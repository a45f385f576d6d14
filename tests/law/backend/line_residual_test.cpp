#include "pled_vins/backend/line_residual.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <doctest/doctest.h>

#include "pled_vins/backend/point_residual.hpp"
#include "pled_vins/geometry/so3.hpp"

namespace pled {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kScale = 300.0;  // f / sigma_px

struct Scene {
  LineFrames frames;
  OrthonormalLine line;
  LineObservation seen;
  double shift_s = 0;
};

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// Uniform in [-scale, scale).
  double operator()(double scale) {
    return scale * (2.0 * static_cast<double>(engine_() >> 11) * 0x1.0p-53 - 1.0);
  }
  Vector3d vector(double scale) {
    const double x = (*this)(scale), y = (*this)(scale), z = (*this)(scale);
    return {x, y, z};
  }
  Pose pose(double metres, double rad) {
    const Vector3d turn = vector(rad);
    return {so3::exp(turn), vector(metres)};
  }

 private:
  std::mt19937_64 engine_;
};

/// What is degenerate about a state, or nearly so.
enum class Trouble {
  kNone,
  kTurned,     ///< the body's rotation within 1e-3 of 180 deg
  kAtCamera,   ///< the line passes the camera's centre at 1 cm
  kAtOrigin,   ///< the line passes its own origin at 1 mm
  kFar,        ///< 3 to 30 km away: nearly at infinity
  kBeside,     ///< the picture lies 10 to 40 from the optical axis: its plane nearly z = 0
  kEndOn,      ///< seen nearly along the line
  kShortSeen,  ///< the ends seen are 1e-9 apart
};
constexpr int kTroubles = 8;

/// The line through two points in front of the camera.
std::array<Vector3d, 2> two_points(Random& random, Trouble trouble) {
  const Vector3d a = Vector3d(0, 0, 5) + random.vector(2);
  const Vector3d b = Vector3d(0, 0, 5) + random.vector(2);
  const double depth = 2.0 + random(1.5);
  switch (trouble) {
    case Trouble::kAtCamera: {
      const Vector3d beside = 0.01 * Vector3d(random(1), random(1), 0).normalized();
      return {beside, beside + a};
    }
    case Trouble::kFar:
      return {std::pow(10.0, 3.5 + random(0.5)) * a, std::pow(10.0, 3.5 + random(0.5)) * b};
    case Trouble::kBeside: {
      const Vector3d foot = depth * Vector3d(random(1), 25 + random(15), 1);
      return {foot, foot + Vector3d(1, random(0.01), random(0.01))};
    }
    case Trouble::kEndOn: return {a, 3.0 * a + random.vector(0.05)};
    default: return {a, b};
  }
}

Scene random_scene(Random& random, Trouble trouble) {
  Scene s;
  s.frames.T_world_body = random.pose(10, 1.5);
  if (trouble == Trouble::kTurned) {
    const Vector3d axis = random.vector(1).normalized();
    s.frames.T_world_body.q = so3::exp((3.14159265 + random(1e-3)) * axis);
  }
  s.frames.T_body_cam = random.pose(0.1, 1.5);
  const Pose T_world_cam = s.frames.T_world_body * s.frames.T_body_cam;
  const std::array<Vector3d, 2> points = two_points(random, trouble);
  const Vector3d a = T_world_cam * points[0], b = T_world_cam * points[1];
  s.frames.origin_world = T_world_cam.p + random.vector(0.5);
  if (trouble == Trouble::kAtOrigin) {
    s.frames.origin_world = a + random(2) * (b - a) + 1e-3 * random.vector(1).normalized();
  }
  const auto line =
      to_orthonormal(line_through(a - s.frames.origin_world, b - s.frames.origin_world));
  REQUIRE(line.has_value());
  s.line = *line;
  s.seen.start_xy = {random(0.6), random(0.6)};
  s.seen.end_xy = {random(0.6), random(0.6)};
  if (trouble == Trouble::kShortSeen) {
    s.seen.end_xy = {s.seen.start_xy[0] + random(1e-9), s.seen.start_xy[1] + random(1e-9)};
  }
  s.seen.start_rate_ps = {random(1), random(1)};
  s.seen.end_rate_ps = {random(1), random(1)};
  s.shift_s = random(0.005);
  return s;
}

PluckerLine in_camera(const Scene& s) {
  Pose T = s.frames.T_world_body;
  T.p -= s.frames.origin_world;
  return (T * s.frames.T_body_cam).inverse() * to_plucker(s.line);
}

/// eq. (11) with the functions of geometry, end by end.
Vector2d by_definition(const Scene& s) {
  const auto l = project(in_camera(s));
  REQUIRE(l.has_value());
  const auto distance = [&](const std::array<double, 2>& xy, const std::array<double, 2>& rate) {
    return l->dot(Vector3d(xy[0] - s.shift_s * rate[0], xy[1] - s.shift_s * rate[1], 1.0));
  };
  return kScale * Vector2d(distance(s.seen.start_xy, s.seen.start_rate_ps),
                           distance(s.seen.end_xy, s.seen.end_rate_ps));
}

bool evaluate(const Scene& s, Vector2d& r, LineJacobians* J) {
  return line_residual(s.frames, s.line, s.seen, s.shift_s, kScale, r, J);
}

Vector2d residual(const Scene& s) {
  Vector2d r = Vector2d::Constant(kNan);
  REQUIRE(evaluate(s, r, nullptr));
  return r;
}

Pose moved(const Pose& T, int axis, double h) {
  Vector3d p = Vector3d::Zero(), theta = Vector3d::Zero();
  (axis < 3 ? p : theta)[axis % 3] = h;
  return {(T.q * so3::exp(theta)).normalized(), T.p + p};
}

/// Central differences of steps h and h / 2, of which the error in h^2 cancels; `change` moves the
/// scene by its second argument.
template <typename Change>
Vector2d numeric(const Scene& scene, double h, const Change& change) {
  const auto slope = [&](double step) -> Vector2d {
    Scene plus = scene, minus = scene;
    change(plus, step);
    change(minus, -step);
    return (residual(plus) - residual(minus)) / (2 * step);
  };
  return (4.0 * slope(h / 2) - slope(h)) / 3.0;
}

/// Worst relative differences of the blocks.
struct Worst {
  double pose = 0, extrinsic = 0, line = 0, time_shift = 0;
};

template <typename A, typename B>
void take_worst(double& worst, const A& got, const B& want) {
  const double here = (got - want).norm() / want.norm();
  worst = here > worst || std::isnan(here) ? here : worst;
}

void compare(const Scene& s, Worst& worst) {
  Vector2d r = Vector2d::Constant(kNan);
  LineJacobians J;
  J.pose.setConstant(kNan);
  J.extrinsic.setConstant(kNan);
  J.line.setConstant(kNan);
  J.time_shift.setConstant(kNan);
  REQUIRE(evaluate(s, r, &J));
  CHECK((r - by_definition(s)).norm() <= 1e-6 * (1.0 + r.norm()));
  // Steps small against what the picture's normal (m) is turned by.
  const PluckerLine cam = in_camera(s), own = to_plucker(s.line);
  const double m = cam.n.head<2>().norm(), d = cam.d.norm();
  const double lever_m = (s.frames.T_world_body.p - s.frames.origin_world).norm() + 0.2;
  const auto step = [m](double turned) { return 1e-3 * std::min(1.0, m / turned); };
  Eigen::Matrix<double, 2, 6> pose, extrinsic;
  Eigen::Matrix<double, 2, 4> line;
  for (int a = 0; a < 6; ++a) {
    const double h = a < 3 ? step(d) : step(cam.n.norm() + 0.2 * d);
    pose.col(a) = numeric(s, h, [a](Scene& x, double by) {
      x.frames.T_world_body = moved(x.frames.T_world_body, a, by);
    });
    extrinsic.col(a) = numeric(s, h, [a](Scene& x, double by) {
      x.frames.T_body_cam = moved(x.frames.T_body_cam, a, by);
    });
  }
  for (int a = 0; a < 4; ++a) {
    const double h = step(own.n.norm() + lever_m * (a < 3 ? own.d.norm() : 1.0));
    line.col(a) = numeric(s, h, [a](Scene& x, double by) {
      LineTangent delta = LineTangent::Zero();
      delta[a] = by;
      x.line = box_plus(x.line, delta);
    });
  }
  const Vector2d shift = numeric(s, 1e-3, [](Scene& x, double by) { x.shift_s += by; });
  take_worst(worst.pose, J.pose, pose);
  take_worst(worst.extrinsic, J.extrinsic, extrinsic);
  take_worst(worst.line, J.line, line);
  take_worst(worst.time_shift, J.time_shift, shift);
}

/// Refused as the header says: a large residual and no Jacobians, all of them set.
void check_refused(const Scene& s) {
  Vector2d r = Vector2d::Constant(kNan);
  LineJacobians J;
  J.pose.setConstant(kNan);
  J.extrinsic.setConstant(kNan);
  J.line.setConstant(kNan);
  J.time_shift.setConstant(kNan);
  CHECK_FALSE(evaluate(s, r, &J));
  CHECK(r == Vector2d::Constant(50 * kScale));
  CHECK(J.pose.isZero(0));
  CHECK(J.extrinsic.isZero(0));
  CHECK(J.line.isZero(0));
  CHECK(J.time_shift.isZero(0));
}

}  // namespace

TEST_SUITE("backend.line_residual") {
  TEST_CASE("the residual is eq. (11) and its Jacobians equal differences in 10000 states") {
    constexpr std::array<const char*, kTroubles> kNames{
        "none",     "turned by 180 deg",  "1 cm from the camera", "1 mm from the origin",
        "far away", "beside the picture", "seen end on",          "ends 1e-9 apart"};
    for (int t = 0; t < kTroubles; ++t) {
      const std::string name = kNames[static_cast<std::size_t>(t)];
      CAPTURE(name);
      Random random(30 + static_cast<std::uint64_t>(t));
      Worst worst;
      for (int i = 0; i < 10000 / kTroubles; ++i) {
        compare(random_scene(random, static_cast<Trouble>(t)), worst);
      }
      CHECK(worst.pose <= 1e-6);
      CHECK(worst.extrinsic <= 1e-6);
      CHECK(worst.line <= 1e-6);
      CHECK(worst.time_shift <= 1e-6);
      MESSAGE(name << ": pose " << worst.pose << ", extrinsic " << worst.extrinsic << ", line "
                   << worst.line << ", time shift " << worst.time_shift);
    }
  }

  TEST_CASE("an end one pixel beside a true line has a residual of 1 / sigma, on it of 0") {
    Random random(40);
    for (int i = 0; i < 100; ++i) {
      Scene s = random_scene(random, Trouble::kNone);
      s.shift_s = 0;
      const auto l = project(in_camera(s));
      REQUIRE(l.has_value());
      const Vector2d foot = -l->z() * l->head<2>();
      const Vector2d along(-l->y(), l->x());
      const double f_px = 200, sigma_px = 0.5;
      const Vector2d beside = foot + 0.3 * along + l->head<2>() / f_px;
      s.seen.start_xy = {foot.x(), foot.y()};
      s.seen.end_xy = {beside.x(), beside.y()};
      Vector2d r = Vector2d::Constant(kNan);
      REQUIRE(line_residual(s.frames, s.line, s.seen, 0, f_px / sigma_px, r, nullptr));
      CHECK(std::abs(r[0]) < 1e-8);
      CHECK(r[1] == doctest::Approx(1 / sigma_px).epsilon(1e-9));
      std::swap(s.seen.start_xy, s.seen.end_xy);
      REQUIRE(line_residual(s.frames, s.line, s.seen, 0, f_px / sigma_px, r, nullptr));
      CHECK(r[0] == doctest::Approx(1 / sigma_px).epsilon(1e-9));
    }
  }

  TEST_CASE("a point of the line moves across it as the point residual says") {
    // The conventions of poses are those of points: a step of the body or of the camera on it moves
    // the picture of an end and the picture of the line alike.
    Random random(41);
    for (int i = 0; i < 200; ++i) {
      Scene s = random_scene(random, Trouble::kNone);
      const PluckerLine cam = in_camera(s);
      const auto l = project(cam);
      REQUIRE(l.has_value());
      const auto x = point_seen_at(cam, {s.seen.start_xy[0], s.seen.start_xy[1]});
      if (!x || x->z() < 0.1) continue;
      const Vector2d xy = x->head<2>() / x->z();
      s.seen.start_xy = {xy.x(), xy.y()};
      s.shift_s = 0;
      Vector2d r;
      LineJacobians J;
      REQUIRE(evaluate(s, r, &J));
      const PointFrames frames{s.frames.T_world_body, s.frames.T_body_cam, s.frames.T_world_body,
                               s.frames.T_body_cam};
      Observation seen;
      seen.xy = {xy.x(), xy.y()};
      PointJacobians P;
      REQUIRE(point_residual(frames, {xy.x(), xy.y(), 1 / x->z()}, seen, 0, kScale, r, &P));
      const Eigen::Matrix<double, 1, 6> pose = -l->head<2>().transpose() * P.pose_j;
      const Eigen::Matrix<double, 1, 6> extrinsic = -l->head<2>().transpose() * P.extrinsic_j;
      CHECK((J.pose.row(0) - pose).norm() <= 1e-9 * J.pose.norm());
      CHECK((J.extrinsic.row(0) - extrinsic).norm() <= 1e-9 * J.extrinsic.norm());
    }
  }

  TEST_CASE("neither the choice of the origin nor motion along the line changes the residual") {
    Random random(42);
    for (int i = 0; i < 200; ++i) {
      Scene s = random_scene(random, Trouble::kNone);
      const Vector2d r = residual(s);
      Scene other = s;
      const Vector3d by = random.vector(3);
      other.frames.origin_world += by;
      const auto line =
          to_orthonormal(Pose{Eigen::Quaterniond::Identity(), -by} * to_plucker(s.line));
      REQUIRE(line.has_value());
      other.line = *line;
      const double sign = in_camera(s).n.dot(in_camera(other).n) < 0 ? -1 : 1;
      CHECK((sign * residual(other) - r).norm() < 1e-9 * (1 + r.norm()));
      s.frames.T_world_body.p += random(1) * to_plucker(s.line).d.normalized();
      CHECK((residual(s) - r).norm() < 1e-9 * (1 + r.norm()));
    }
  }

  TEST_CASE("without the extrinsic its Jacobian is 0 and the others are the same") {
    Random random(43);
    const Scene s = random_scene(random, Trouble::kNone);
    Vector2d r;
    LineJacobians with, without;
    without.with_extrinsic = false;
    without.extrinsic.setConstant(kNan);
    REQUIRE(evaluate(s, r, &with));
    REQUIRE(evaluate(s, r, &without));
    CHECK(without.extrinsic.isZero(0));
    CHECK(with.pose == without.pose);
    CHECK(with.line == without.line);
    CHECK(with.time_shift == without.time_shift);
  }

  TEST_CASE(
      "a line through the camera or pictured near infinity is refused with a large residual") {
    Scene s;
    s.frames.origin_world = {1, 2, 3};
    const auto set = [&s](const Vector3d& a, const Vector3d& b) {
      const auto line =
          to_orthonormal(line_through(a - s.frames.origin_world, b - s.frames.origin_world));
      REQUIRE(line.has_value());
      s.line = *line;
    };
    set({0, 0, 1}, {0.3, -0.2, 7});
    Vector2d r;
    CHECK(evaluate(s, r, nullptr));
    set({0, 0, 1}, {0, 0, 7});
    check_refused(s);
    set({-0.1, 0.4, 2}, {-0.2, 0.8, 4});
    check_refused(s);
    set({0, 1, 0}, {1, 1, 0});
    check_refused(s);
    set({0, 51, 1}, {1, 51, 1});
    check_refused(s);
    set({0, 49, 1}, {1, 49, 1});
    CHECK(evaluate(s, r, nullptr));
  }

  TEST_CASE("NaN and infinity in any input are refused with finite outputs") {
    Random random(44);
    const Scene good = random_scene(random, Trouble::kNone);
    const auto refused_with = [&good](const auto& change) {
      Scene s = good;
      change(s);
      check_refused(s);
    };
    for (const double bad : {kNan, std::numeric_limits<double>::infinity()}) {
      for (int k = 0; k < 3; ++k) {
        refused_with([&](Scene& s) { s.frames.T_world_body.p[k] = bad; });
        refused_with([&](Scene& s) { s.frames.T_body_cam.p[k] = bad; });
        refused_with([&](Scene& s) { s.frames.origin_world[k] = bad; });
      }
      for (int k = 0; k < 4; ++k) {
        refused_with([&](Scene& s) { s.frames.T_world_body.q.coeffs()[k] = bad; });
        refused_with([&](Scene& s) { s.frames.T_body_cam.q.coeffs()[k] = bad; });
        refused_with([&](Scene& s) { s.line.U.coeffs()[k] = bad; });
      }
      for (std::size_t k = 0; k < 2; ++k) {
        refused_with([&](Scene& s) { s.seen.start_xy[k] = bad; });
        refused_with([&](Scene& s) { s.seen.end_xy[k] = bad; });
        refused_with([&](Scene& s) { s.seen.end_rate_ps[k] = bad; });
      }
      refused_with([&](Scene& s) { s.line.phi_rad = bad; });
      refused_with([&](Scene& s) { s.shift_s = bad; });
    }
  }
}

}  // namespace pled
