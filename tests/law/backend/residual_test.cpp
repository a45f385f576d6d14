#include <random>

#include <doctest/doctest.h>

#include "pled_vins/backend/factors.hpp"
#include "pled_vins/geometry/so3.hpp"

namespace pled {
namespace {

constexpr double kStep = 1e-6;

struct Scene {
  PointFrames frames;
  std::array<double, 3> point{};
  Observation seen;
  double shift_s = 0;
};

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double operator()(double scale) {
    return scale * (2.0 * static_cast<double>(engine_() >> 11) * 0x1.0p-53 - 1.0);
  }
  Eigen::Vector3d vector(double scale) {
    const double x = (*this)(scale), y = (*this)(scale), z = (*this)(scale);
    return {x, y, z};
  }
  Pose pose(double metres, double rad) { return {so3::exp(vector(rad)), vector(metres)}; }
  NavState state() {
    NavState s;
    s.p_wb = vector(2);
    s.q_wb = so3::exp(vector(1));
    s.v_wb = vector(2);
    s.bg = vector(0.02);
    s.ba = vector(0.2);
    return s;
  }

 private:
  std::mt19937_64 engine_;
};

Scene random_scene(Random& random) {
  Scene s;
  s.frames = {random.pose(0.5, 0.2), random.pose(0.05, 0.2), random.pose(0.5, 0.2),
              random.pose(0.05, 0.2)};
  s.point = {random(0.4), random(0.4), 0.3 + random(0.25)};
  s.seen.xy = {random(0.5), random(0.5)};
  s.seen.rate_ps = {random(1), random(1)};
  s.shift_s = random(0.005);
  return s;
}

Pose moved(const Pose& T, int axis, double h) {
  Vector6d d = Vector6d::Zero();
  d[axis] = h;
  return {(T.q * so3::exp(d.tail<3>())).normalized(), T.p + d.head<3>()};
}

Eigen::Vector2d residual(const Scene& s) {
  Eigen::Vector2d r = Eigen::Vector2d::Constant(std::nan(""));
  REQUIRE(point_residual(s.frames, s.point, s.seen, s.shift_s, 300.0, r, nullptr));
  return r;
}

/// Column `axis` of the Jacobian by central differences; `change` moves the scene by h.
template <typename Change>
Eigen::Vector2d numeric(const Scene& scene, const Change& change) {
  Scene plus = scene, minus = scene;
  change(plus, kStep);
  change(minus, -kStep);
  return (residual(plus) - residual(minus)) / (2 * kStep);
}

}  // namespace

TEST_SUITE("backend.factors") {
  TEST_CASE("the point residual's Jacobians equal central differences") {
    Random random(7);
    for (int trial = 0; trial < 50; ++trial) {
      CAPTURE(trial);
      const Scene s = random_scene(random);
      Eigen::Vector2d r;
      PointJacobians J;
      if (!point_residual(s.frames, s.point, s.seen, s.shift_s, 300.0, r, &J)) continue;
      const auto close = [](const Eigen::Vector2d& got, const Eigen::Vector2d& want) {
        CHECK((got - want).norm() <= 1e-4 * (1.0 + want.norm()));
      };
      for (int a = 0; a < 6; ++a) {
        CAPTURE(a);
        close(J.pose_i.col(a), numeric(s, [a](Scene& x, double h) {
                x.frames.T_world_body_i = moved(x.frames.T_world_body_i, a, h);
              }));
        close(J.pose_j.col(a), numeric(s, [a](Scene& x, double h) {
                x.frames.T_world_body_j = moved(x.frames.T_world_body_j, a, h);
              }));
        close(J.extrinsic_i.col(a), numeric(s, [a](Scene& x, double h) {
                x.frames.T_body_cam_i = moved(x.frames.T_body_cam_i, a, h);
              }));
        close(J.extrinsic_j.col(a), numeric(s, [a](Scene& x, double h) {
                x.frames.T_body_cam_j = moved(x.frames.T_body_cam_j, a, h);
              }));
      }
      for (std::size_t a = 0; a < 3; ++a)
        close(J.point.col(static_cast<int>(a)),
              numeric(s, [a](Scene& x, double h) { x.point[a] += h; }));
      close(J.time_shift, numeric(s, [](Scene& x, double h) { x.shift_s += h; }));
    }
  }

  TEST_CASE("a point at infinity has a finite residual that translation does not change") {
    Random random(8);
    Scene s = random_scene(random);
    s.point[2] = 0.0;
    const Eigen::Vector2d before = residual(s);
    s.frames.T_world_body_j.p += Eigen::Vector3d(3, -2, 1);
    CHECK((residual(s) - before).norm() < 1e-9);
  }

  TEST_CASE("a point behind the camera is told and still has a finite residual") {
    Scene s;
    s.point = {0, 0, 1.0};
    s.frames.T_world_body_j.p = {0, 0, 5};
    Eigen::Vector2d r = Eigen::Vector2d::Constant(std::nan(""));
    PointJacobians J;
    CHECK_FALSE(point_residual(s.frames, s.point, s.seen, 0, 300, r, &J));
    CHECK(r.allFinite());
    CHECK(J.pose_j.allFinite());
  }

  TEST_CASE("same-place and state-prior Jacobians equal central differences") {
    Random random(9);
    const FactorSettings settings;
    const NavState i = random.state();
    NavState j = box_plus(i, Vector15d::Constant(0.01));
    StatePrior prior;
    prior.mean = random.state();
    prior.mean.q_wb = i.q_wb * so3::exp({0.1, -0.2, 0.15});
    prior.sqrt_information = Matrix15d::Identity() * 3.0;
    prior.sqrt_information(3, 4) = 0.7;
    Vector6d r;
    Matrix6d J_i, J_j;
    evaluate_same_place(settings, 0.3, i, j, i, j, r, &J_i, &J_j);
    Vector15d rp;
    Matrix15d J_p;
    evaluate_state_prior(prior, i, i, rp, &J_p);
    for (int a = 0; a < 15; ++a) {
      CAPTURE(a);
      Vector15d d = Vector15d::Zero();
      d[a] = kStep;
      Vector15d p_plus, p_minus;
      evaluate_state_prior(prior, box_plus(i, d), i, p_plus, nullptr);
      evaluate_state_prior(prior, box_plus(i, -d), i, p_minus, nullptr);
      CHECK(((p_plus - p_minus) / (2 * kStep) - J_p.col(a)).norm() < 1e-5);
      if (a >= 6) continue;
      Vector6d plus, minus;
      evaluate_same_place(settings, 0.3, box_plus(i, d), j, i, j, plus, nullptr, nullptr);
      evaluate_same_place(settings, 0.3, box_plus(i, -d), j, i, j, minus, nullptr, nullptr);
      CHECK(((plus - minus) / (2 * kStep) - J_i.col(a)).norm() < 1e-4 * J_i.norm());
      evaluate_same_place(settings, 0.3, i, box_plus(j, d), i, j, plus, nullptr, nullptr);
      evaluate_same_place(settings, 0.3, i, box_plus(j, -d), i, j, minus, nullptr, nullptr);
      CHECK(((plus - minus) / (2 * kStep) - J_j.col(a)).norm() < 1e-4 * J_j.norm());
    }
  }

  TEST_CASE(
      "the gain of a robust loss goes to 1 without robustness and has its closed value at c = 2") {
    CHECK(robust_gain(100.0) == doctest::Approx(1.0).epsilon(2e-3));
    // With u = s/2 and E1 the exponential integral, e^2 E1(2) = 0.361328617:
    // E[w] = 2 e^2 E1(2), E[w^2] = 2 - 4 e^2 E1(2), E[w^2 u] = 12 e^2 E1(2) - 4.
    const double e = 0.361328617;
    const double w = 2 * e, w2 = 2 - 4 * e, w2u = 12 * e - 4;
    CHECK(robust_gain(2.0) == doctest::Approx(w2 * w2 / (w2u * w)).epsilon(1e-5));
  }
}

}  // namespace pled
