#include <random>

#include <Eigen/Eigenvalues>
#include <doctest/doctest.h>

#include "src/backend/start/linear.hpp"

using namespace pled;
using start::Matrix6d;
using start::Vector6d;

TEST_SUITE("start.gravity_constraint") {
  TEST_CASE("no other gravity of the same size makes the quadratic smaller") {
    std::mt19937_64 random(7);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-52 - 1.0; };
    constexpr double kGravity = 9.81;
    for (int trial = 0; trial < 20; ++trial) {
      Matrix6d A;
      Vector6d b;
      for (int i = 0; i < 6; ++i) {
        b[i] = 30 * unit();
        for (int j = 0; j < 6; ++j) A(i, j) = unit();
      }
      const Matrix6d H = A * A.transpose() + 0.01 * Matrix6d::Identity();
      const std::optional<Vector6d> x = start::solve_with_gravity(H, b, kGravity);
      REQUIRE(x.has_value());
      CHECK(x->tail<3>().norm() == doctest::Approx(kGravity).epsilon(1e-8));
      const auto cost = [&](const Vector6d& y) { return 0.5 * y.dot(H * y) - b.dot(y); };
      const double best = cost(*x);
      for (int k = 0; k < 200; ++k) {
        Vector6d y = *x;
        const double size = k % 2 == 0 ? 0.01 : 10.0;  // near by and far away
        for (int i = 0; i < 6; ++i) y[i] += size * unit();
        y.tail<3>() *= kGravity / y.tail<3>().norm();
        CHECK(cost(y) >= best - 1e-7 * std::abs(best));
      }
    }
  }
}
