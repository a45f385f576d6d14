#include "pled_vins/imu/preintegration.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include <Eigen/Cholesky>
#include <doctest/doctest.h>

#include "law/imu/hand_held_motion.hpp"
#include "pled_vins/geometry/so3.hpp"
#include "pled_vins/imu/imu_history.hpp"
#include "pled_vins/imu/truth_check.hpp"

namespace {

using Eigen::Vector3d;
using pled::ImuNoise;
using pled::ImuSample;
using pled::Matrix15d;
using pled::NavState;
using pled::Preintegration;
using pled::Vector15d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
const pled::support::HandHeldMotion kMotion({3.0, 2.6, 3.4});

/// What the motion's IMU reads from `start_s` on, biases added.
std::vector<ImuSample> readings(double start_s, int steps, double rate_hz, const Vector3d& bg,
                                const Vector3d& ba) {
  std::vector<ImuSample> out;
  for (int i = 0; i <= steps; ++i) {
    ImuSample s = kMotion.imu(start_s + i / rate_hz);
    for (std::size_t k = 0; k < 3; ++k) {
      s.gyro_radps[k] += bg[static_cast<Eigen::Index>(k)];
      s.accel_mps2[k] += ba[static_cast<Eigen::Index>(k)];
    }
    out.push_back(s);
  }
  return out;
}

Vector3d normal3(std::mt19937_64& random, double sigma) {
  std::normal_distribution<double> normal;
  return sigma * Vector3d(normal(random), normal(random), normal(random));
}

Vector15d normal15(std::mt19937_64& random, double sigma) {
  std::normal_distribution<double> normal;
  Vector15d v;
  for (int i = 0; i < 15; ++i) v[i] = sigma * normal(random);
  return v;
}

Preintegration integrated(std::span<const ImuSample> s, const Vector3d& bg, const Vector3d& ba,
                          const ImuNoise& noise = {}) {
  Preintegration p;
  REQUIRE(p.integrate(s, bg, ba, noise));
  return p;
}

}  // namespace

TEST_SUITE("imu.preintegration") {
  TEST_CASE("gravity is what the model of the sensor says") {
    for (const double gravity_mps2 : {9.78, 9.83}) {  // at the equator, at the pole
      std::vector<pled::ImuSample> samples;
      for (std::int64_t us = 0; us <= 1'000'000; us += 5000)
        samples.push_back({{us}, {0, 0, 0}, {0, 0, gravity_mps2}});
      pled::ImuNoise noise;
      noise.gravity_mps2 = gravity_mps2;
      Preintegration p;
      REQUIRE(p.integrate(samples, Vector3d::Zero(), Vector3d::Zero(), noise));
      const NavState rest;
      CHECK(p.predict(rest).p_wb.norm() < 1e-9);  // it lies on the table
      CHECK(p.predict(rest).v_wb.norm() < 1e-9);
      pled::Vector15d r;
      p.residual(rest, rest, r, nullptr, nullptr);
      CHECK(r.norm() < 1e-9);
      noise.gravity_mps2 = 9.81;
      REQUIRE(p.integrate(samples, Vector3d::Zero(), Vector3d::Zero(), noise));
      CHECK(p.predict(rest).p_wb.z() == doctest::Approx(0.5 * (gravity_mps2 - 9.81)));
    }
  }

  TEST_CASE("predict follows the motion it was made from, whatever the start") {
    const Vector3d bg(0.01, -0.02, 0.03);
    const Vector3d ba(0.1, 0.2, -0.1);
    for (const double start_s : {0.0, 1.23, 7.5}) {
      CAPTURE(start_s);
      const Preintegration p = integrated(readings(start_s, 100, 200.0, bg, ba), bg, ba);
      NavState start = kMotion.state(start_s);
      start.bg = bg;
      start.ba = ba;
      NavState end = kMotion.state(start_s + 0.5);
      end.bg = bg;
      end.ba = ba;
      const NavState got = p.predict(start);
      CHECK(got.t == end.t);
      const Vector15d d = pled::box_minus(got, end);
      // 4th order: the truncation at 3 Hz and 5 ms is (2 pi 3 * 0.005)^4 = 8e-5 of the signal,
      // 0.05 rad and 0.02 m of shaking.
      CHECK(d.segment<3>(3).norm() < 1e-5);
      CHECK(d.segment<3>(0).norm() < 1e-5);
      CHECK(d.segment<3>(6).norm() < 1e-4);
    }
  }

  TEST_CASE("halving the step divides the error by ten or more: the order is above three") {
    double error[2];
    for (int k = 0; k < 2; ++k) {
      const double rate_hz = k == 0 ? 100.0 : 200.0;
      const Preintegration p =
          integrated(readings(0.3, k == 0 ? 100 : 200, rate_hz, {0, 0, 0}, {0, 0, 0}),
                     Vector3d::Zero(), Vector3d::Zero());
      error[k] =
          pled::box_minus(p.predict(kMotion.state(0.3)), kMotion.state(1.3)).segment<3>(3).norm();
    }
    CHECK(error[1] < 0.1 * error[0]);
  }

  TEST_CASE("free fall and standing still have their textbook increments") {
    std::vector<ImuSample> still;
    std::vector<ImuSample> falling;
    for (int i = 0; i <= 10; ++i) {
      still.push_back({{i * 10'000}, {0, 0, 0}, {0, 0, 9.81}});
      falling.push_back({{i * 10'000}, {0, 0, 0}, {0, 0, 0}});
    }
    const NavState stays = integrated(still, {0, 0, 0}, {0, 0, 0}).predict(NavState{});
    CHECK(stays.p_wb.norm() < 1e-14);
    CHECK(stays.v_wb.norm() < 1e-14);
    const NavState fell = integrated(falling, {0, 0, 0}, {0, 0, 0}).predict(NavState{});
    CHECK(fell.p_wb.z() == doctest::Approx(-0.5 * 9.81 * 0.01).epsilon(1e-12));
    CHECK(fell.v_wb.z() == doctest::Approx(-0.981).epsilon(1e-12));
  }

  TEST_CASE("the residual is zero at the predicted state") {
    std::mt19937_64 random(21);
    const Vector3d bg = normal3(random, 0.02);
    const Vector3d ba = normal3(random, 0.1);
    const Preintegration p = integrated(readings(2.0, 40, 200.0, bg, ba), bg, ba);
    const NavState i = pled::box_plus(kMotion.state(2.0), normal15(random, 0.05));
    Vector15d r = Vector15d::Constant(kNaN);
    p.residual(i, p.predict(i), r, nullptr, nullptr);
    CHECK(r.norm() < 1e-12);
  }

  TEST_CASE("residual Jacobians by both states are central differences, away from the solution") {
    std::mt19937_64 random(22);
    constexpr double kStep = 1e-5;
    for (int trial = 0; trial < 10; ++trial) {
      const Vector3d bg = normal3(random, 0.02);
      const Vector3d ba = normal3(random, 0.1);
      const Preintegration p = integrated(readings(0.37 * trial, 40, 200.0, bg, ba), bg, ba);
      NavState i = pled::box_plus(kMotion.state(0.37 * trial), normal15(random, 0.05));
      const NavState j = pled::box_plus(p.predict(i), normal15(random, 0.2));
      Vector15d r;
      Matrix15d d_i = Matrix15d::Constant(kNaN);
      Matrix15d d_j = Matrix15d::Constant(kNaN);
      p.residual(i, j, r, &d_i, &d_j);
      for (int k = 0; k < 15; ++k) {
        CAPTURE(k);
        const Vector15d d = kStep * Vector15d::Unit(k);
        Vector15d plus;
        Vector15d minus;
        p.residual(pled::box_plus(i, d), j, plus, nullptr, nullptr);
        p.residual(pled::box_plus(i, -d), j, minus, nullptr, nullptr);
        CHECK((d_i.col(k) - (plus - minus) / (2.0 * kStep)).norm() < 1e-8);
        p.residual(i, pled::box_plus(j, d), plus, nullptr, nullptr);
        p.residual(i, pled::box_plus(j, -d), minus, nullptr, nullptr);
        CHECK((d_j.col(k) - (plus - minus) / (2.0 * kStep)).norm() < 1e-8);
      }
    }
  }

  TEST_CASE("bias corrections are the derivatives of integrating anew") {
    std::mt19937_64 random(23);
    constexpr double kStep = 1e-5;
    const Vector3d bg = normal3(random, 0.02);
    const Vector3d ba = normal3(random, 0.1);
    const auto samples = readings(1.1, 60, 200.0, bg, ba);
    const Preintegration p = integrated(samples, bg, ba);
    for (int k = 0; k < 3; ++k) {
      const Vector3d d = kStep * Vector3d::Unit(k);
      // Second differences of anew against corrected: zero to first order in the step.
      const Preintegration g_plus = integrated(samples, bg + d, ba);
      const Preintegration g_minus = integrated(samples, bg - d, ba);
      const Vector3d q_anew =
          (pled::so3::log(p.delta_q(bg).conjugate() * g_plus.delta_q(bg + d)) -
           pled::so3::log(p.delta_q(bg).conjugate() * g_minus.delta_q(bg - d))) /
          (2.0 * kStep);
      const Vector3d q_corrected = (pled::so3::log(p.delta_q(bg).conjugate() * p.delta_q(bg + d)) -
                                    pled::so3::log(p.delta_q(bg).conjugate() * p.delta_q(bg - d))) /
                                   (2.0 * kStep);
      // What remains is the commutator part of a step, of order (w h)^2 = 4e-4 of a step of 5 ms.
      CHECK((q_anew - q_corrected).norm() < 1e-5);
      const Vector3d v_anew =
          (g_plus.delta_v(bg + d, ba) - g_minus.delta_v(bg - d, ba)) / (2.0 * kStep);
      CHECK((v_anew - (p.delta_v(bg + d, ba) - p.delta_v(bg - d, ba)) / (2.0 * kStep)).norm() <
            1e-4);
      const Vector3d p_anew =
          (g_plus.delta_p(bg + d, ba) - g_minus.delta_p(bg - d, ba)) / (2.0 * kStep);
      CHECK((p_anew - (p.delta_p(bg + d, ba) - p.delta_p(bg - d, ba)) / (2.0 * kStep)).norm() <
            1e-4);
      const Preintegration a_plus = integrated(samples, bg, ba + d);
      const Preintegration a_minus = integrated(samples, bg, ba - d);
      const Vector3d va_anew =
          (a_plus.delta_v(bg, ba + d) - a_minus.delta_v(bg, ba - d)) / (2.0 * kStep);
      CHECK((va_anew - (p.delta_v(bg, ba + d) - p.delta_v(bg, ba - d)) / (2.0 * kStep)).norm() <
            1e-9);
      const Vector3d pa_anew =
          (a_plus.delta_p(bg, ba + d) - a_minus.delta_p(bg, ba - d)) / (2.0 * kStep);
      CHECK((pa_anew - (p.delta_p(bg, ba + d) - p.delta_p(bg, ba - d)) / (2.0 * kStep)).norm() <
            1e-9);
    }
  }

  TEST_CASE("the covariance of white noise on a body at rest is the integral's closed form") {
    const ImuNoise noise{.accel_density = 0.02,
                         .accel_walk = 1e-9,
                         .gyro_density = 1e-9,
                         .gyro_walk = 1e-9,
                         .rate_hz = 200.0};
    for (const int steps : {1, 10, 400}) {
      CAPTURE(steps);
      std::vector<ImuSample> still;
      for (int i = 0; i <= steps; ++i) still.push_back({{i * 5'000}, {0, 0, 0}, {0, 0, 9.81}});
      const Matrix15d P = integrated(still, {0, 0, 0}, {0, 0, 0}, noise).covariance();
      const double T = steps * 0.005;
      const double s2 = 0.02 * 0.02;
      CHECK(P(6, 6) == doctest::Approx(s2 * T).epsilon(1e-6));
      CHECK(P(0, 6) == doctest::Approx(s2 * T * T / 2.0).epsilon(1e-6));
      CHECK(P(0, 0) == doctest::Approx(s2 * T * T * T / 3.0).epsilon(1e-6));
    }
  }

  TEST_CASE("the square root of information whitens the covariance, for one step and for many") {
    for (const int steps : {1, 2, 10, 200, 1000}) {
      CAPTURE(steps);
      const Preintegration p = integrated(readings(0.0, steps, 200.0, {0, 0, 0}, {0, 0, 0}),
                                          Vector3d::Zero(), Vector3d::Zero());
      const Matrix15d S = p.sqrt_information();
      CHECK((S * p.covariance() * S.transpose() - Matrix15d::Identity()).norm() < 1e-8);
      CHECK((p.covariance() - p.covariance().transpose()).norm() == 0.0);
    }
  }

  TEST_CASE("bad input leaves an empty preintegration") {
    const auto good = readings(0.0, 10, 200.0, {0, 0, 0}, {0, 0, 0});
    const auto refused = [](std::span<const ImuSample> s, const Vector3d& bg,
                            const ImuNoise& noise) {
      Preintegration p;
      REQUIRE(p.integrate(readings(0.0, 4, 200.0, {0, 0, 0}, {0, 0, 0}), {0, 0, 0}, {0, 0, 0}, {}));
      return !p.integrate(s, bg, Vector3d::Zero(), noise) && p.empty();
    };
    CHECK(refused(std::span(good).first(1), Vector3d::Zero(), {}));
    CHECK(refused(std::span(good).first(0), Vector3d::Zero(), {}));
    CHECK(refused(good, Vector3d(kNaN, 0, 0), {}));
    auto bad = good;
    bad[5].gyro_radps[1] = kNaN;
    CHECK(refused(bad, Vector3d::Zero(), {}));
    bad = good;
    bad[5].t = bad[4].t;
    CHECK(refused(bad, Vector3d::Zero(), {}));
    CHECK(refused(good, Vector3d::Zero(), ImuNoise{.gyro_density = 0.0}));
    CHECK(refused(good, Vector3d::Zero(), ImuNoise{.accel_walk = kNaN}));
  }

  TEST_CASE("box plus after box minus gives the state back, and the reverse") {
    std::mt19937_64 random(24);
    for (int i = 0; i < 50; ++i) {
      const NavState x = pled::box_plus(NavState{}, normal15(random, 0.7));
      const NavState y = pled::box_plus(NavState{}, normal15(random, 0.7));
      CHECK(pled::box_minus(pled::box_plus(x, pled::box_minus(y, x)), y).norm() < 1e-13);
      const Vector15d d = normal15(random, 0.5);
      CHECK((pled::box_minus(pled::box_plus(x, d), x) - d).norm() < 1e-13);
    }
  }
}
