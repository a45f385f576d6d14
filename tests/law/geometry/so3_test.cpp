#include "pled_vins/geometry/so3.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
namespace so3 = pled::so3;

constexpr double kPi = std::numbers::pi;

Vector3d random_unit(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(random), normal(random), normal(random)).normalized();
}

/// Angles at which closed forms and series meet, and where closed forms usually fail.
constexpr double kAngles[] = {0.0,  1e-12,  1e-8,   1e-6, 1e-4, 1e-3, 0.0199,     0.0201,
                              0.09, 0.0999, 0.1001, 0.5,  1.0,  3.0,  kPi - 1e-4, kPi - 1e-9};

/// The exponential's definition: its power series, summed until nothing changes.
Matrix3d exp_by_definition(const Vector3d& phi) {
  Matrix3d sum = Matrix3d::Identity();
  Matrix3d term = Matrix3d::Identity();
  for (int k = 1; k < 60; ++k) {
    term = (term * so3::skew(phi) / k).eval();
    sum += term;
  }
  return sum;
}

/// J_r's definition, sum (-1)^k phi^k / (k + 1)!.
Matrix3d right_jacobian_by_definition(const Vector3d& phi) {
  Matrix3d sum = Matrix3d::Identity();
  Matrix3d term = Matrix3d::Identity();
  for (int k = 1; k < 60; ++k) {
    term = (term * -so3::skew(phi) / (k + 1)).eval();
    sum += term;
  }
  return sum;
}

}  // namespace

TEST_SUITE("geometry.so3") {
  TEST_CASE("skew(a) b is a x b") {
    const Vector3d a(1.0, -2.0, 3.0);
    const Vector3d b(0.5, 4.0, -1.0);
    CHECK((so3::skew(a) * b - a.cross(b)).norm() == 0.0);
  }

  TEST_CASE("exp equals the power series and has unit norm at any angle") {
    std::mt19937_64 random(1);
    for (const double angle : kAngles) {
      CAPTURE(angle);
      const Vector3d phi = angle * random_unit(random);
      const Quaterniond q = so3::exp(phi);
      CHECK(std::abs(q.norm() - 1.0) < 1e-15);
      CHECK((q.toRotationMatrix() - exp_by_definition(phi)).norm() < 2e-14);
    }
  }

  TEST_CASE("log after exp gives the rotation vector back, to rounding, from zero to pi") {
    std::mt19937_64 random(2);
    for (const double angle : kAngles) {
      for (int i = 0; i < 20; ++i) {
        CAPTURE(angle);
        const Vector3d phi = angle * random_unit(random);
        CHECK((so3::log(so3::exp(phi)) - phi).norm() <= 4e-16 + 4e-15 * angle);
      }
    }
  }

  TEST_CASE("exp after log gives the rotation back for random quaternions of either sign") {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 200; ++i) {
      const Quaterniond q =
          Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
      const Quaterniond back = so3::exp(so3::log(q));
      CHECK(std::abs(std::abs(back.dot(q)) - 1.0) < 1e-14);
      CHECK((back.toRotationMatrix() - q.toRotationMatrix()).norm() < 1e-14);
      CHECK(so3::log(q).norm() <= kPi + 1e-15);
    }
  }

  TEST_CASE("log of a half turn has length pi") {
    CHECK(so3::log(Quaterniond(0.0, 0.0, 1.0, 0.0)).norm() == doctest::Approx(kPi).epsilon(1e-15));
  }

  TEST_CASE("the right Jacobian equals its series, and its inverse inverts it") {
    std::mt19937_64 random(4);
    for (const double angle : kAngles) {
      CAPTURE(angle);
      const Vector3d phi = angle * random_unit(random);
      const Matrix3d J = so3::right_jacobian(phi);
      CHECK((J - right_jacobian_by_definition(phi)).norm() < 1e-13);
      CHECK((J * so3::right_jacobian_inverse(phi) - Matrix3d::Identity()).norm() < 1e-12);
    }
  }

  TEST_CASE("the right Jacobian is the central difference of exp, its inverse that of log") {
    std::mt19937_64 random(5);
    constexpr double kStep = 1e-5;
    for (const double angle : {0.0, 1e-3, 0.3, 1.0, 2.5}) {
      CAPTURE(angle);
      const Vector3d phi = angle * random_unit(random);
      const Quaterniond q = so3::exp(phi);
      Matrix3d J;
      Matrix3d J_inverse;
      for (int k = 0; k < 3; ++k) {
        const Vector3d d = kStep * Vector3d::Unit(k);
        J.col(k) = (so3::log(q.conjugate() * so3::exp(phi + d)) -
                    so3::log(q.conjugate() * so3::exp(phi - d))) /
                   (2.0 * kStep);
        J_inverse.col(k) = (so3::log(q * so3::exp(d)) - so3::log(q * so3::exp(-d))) / (2.0 * kStep);
      }
      CHECK((J - so3::right_jacobian(phi)).norm() < 1e-9);
      CHECK((J_inverse - so3::right_jacobian_inverse(phi)).norm() < 1e-9);
    }
  }

  TEST_CASE("rotation_between turns one direction into the other by the angle between them") {
    std::mt19937_64 random(6);
    for (int i = 0; i < 200; ++i) {
      const Vector3d a = random_unit(random);
      const Vector3d b = random_unit(random);
      const Quaterniond q = so3::rotation_between(3.0 * a, 0.2 * b);
      CHECK((q * a - b).norm() < 1e-14);
      const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
      CHECK(so3::log(q).norm() == doctest::Approx(angle).epsilon(1e-12));
    }
  }

  TEST_CASE("rotation_between is accurate for equal, nearly opposite and opposite directions") {
    std::mt19937_64 random(7);
    for (const double off : {0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-3}) {
      for (int i = 0; i < 20; ++i) {
        CAPTURE(off);
        const Vector3d a = random_unit(random);
        const Vector3d b = (a + off * random_unit(random)).normalized();
        CHECK((so3::rotation_between(a, b) * a - b).norm() < 2e-14);
        CHECK((so3::rotation_between(a, -b) * a + b).norm() < 2e-14);
      }
    }
  }
}
