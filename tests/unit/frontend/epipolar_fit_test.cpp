#include "pled_vins/frontend/epipolar_fit.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"

namespace pled {
namespace {

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

constexpr double kFocal_px = 200.0;
constexpr double kLoose_rad = 1e3;  ///< as good as no expectation of the missed rotation

/// Points before a camera that moves by a known rotation and translation.
struct Scene {
  Eigen::Matrix3d R_to_from = so3::exp({0.02, -0.05, 0.03}).toRotationMatrix();
  Eigen::Vector3d t_to_from{0.3, 0.1, 0.2};

  [[nodiscard]] Eigen::Vector3d direction() const { return t_to_from.normalized(); }

  /// `moving` of them go somewhere else by themselves, 10 px in the picture.
  [[nodiscard]] std::vector<BearingPair> pairs(std::size_t n, double noise_px, std::uint64_t seed,
                                               std::size_t moving = 0) const {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::normal_distribution<double> noise(0.0, noise_px / kFocal_px);
    std::vector<BearingPair> out;
    for (std::size_t i = 0; i < n; ++i) {
      const double depth_m = 5.0 + 3.0 * unit(random);
      const Eigen::Vector3d from(0.6 * unit(random), 0.45 * unit(random), 1.0);
      const Eigen::Vector3d to = R_to_from * (depth_m * from) + t_to_from;
      BearingPair pair{from.x(), from.y(), to.x() / to.z(), to.y() / to.z()};
      if (noise_px > 0.0) {
        pair.to_x += noise(random);
        pair.to_y += noise(random);
      }
      if (i < moving) {
        const double angle = 3.14159265 * unit(random);
        pair.to_x += 10.0 / kFocal_px * std::cos(angle);
        pair.to_y += 10.0 / kFocal_px * std::sin(angle);
      }
      out.push_back(pair);
    }
    return out;
  }
};

double angle_rad(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Distance of the second bearing to the epipolar line of the first, px, of a motion that differs
/// from the scene's by a rotation (three) and by the direction's tangents (two).
double distance_px(const Scene& scene, const BearingPair& pair, const Vector5d& off) {
  const Eigen::Vector3d t = scene.direction();
  const Eigen::Vector3d u = t.unitOrthogonal();
  const Eigen::Vector3d moved = (t + off[3] * u + off[4] * t.cross(u)).normalized();
  const Eigen::Vector3d a =
      so3::exp(off.head<3>()) * (scene.R_to_from * Eigen::Vector3d(pair.from_x, pair.from_y, 1.0));
  const Eigen::Vector3d line = moved.cross(a);
  return kFocal_px * Eigen::Vector3d(pair.to_x, pair.to_y, 1.0).dot(line) / line.head<2>().norm();
}

Vector5d slope(const Scene& scene, const BearingPair& pair) {
  constexpr double kStep = 1e-6;
  Vector5d J;
  for (int k = 0; k < 5; ++k)
    J[k] = (distance_px(scene, pair, kStep * Vector5d::Unit(k)) -
            distance_px(scene, pair, -kStep * Vector5d::Unit(k))) /
           (2.0 * kStep);
  return J;
}

/// The least covariance that any fit without bias can have: (J^T J)^-1 sigma^2 (Cramer, Rao).
Matrix5d least_covariance(const Scene& scene, const std::vector<BearingPair>& exact,
                          double noise_px) {
  Matrix5d information = Matrix5d::Zero();
  for (const BearingPair& pair : exact) {
    const Vector5d J = slope(scene, pair);
    information += J * J.transpose() / (noise_px * noise_px);
  }
  return information.inverse();
}

/// Error of the direction, rad, of plain least squares, which counts every pair alike.
double plain_error_rad(const Scene& scene, const std::vector<BearingPair>& pairs) {
  Matrix5d H = Matrix5d::Zero();
  Vector5d g = Vector5d::Zero();
  for (const BearingPair& pair : pairs) {
    const Vector5d J = slope(scene, pair);
    H += J * J.transpose();
    g -= distance_px(scene, pair, Vector5d::Zero()) * J;
  }
  const Vector5d off = H.inverse() * g;
  return off.tail<2>().norm();
}

}  // namespace

TEST_SUITE("frontend.epipolar_fit") {
  TEST_CASE("without noise the direction and the rotation that the gyro missed are found exactly") {
    const Scene scene;
    const std::vector<BearingPair> pairs = scene.pairs(60, 0.0, 1);
    for (const Eigen::Vector3d& missed_rad :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.004, -0.003, 0.005)}) {
      CAPTURE(missed_rad.norm());
      const Eigen::Matrix3d R_gyro = so3::exp(-missed_rad).toRotationMatrix() * scene.R_to_from;
      const Eigen::Vector3d start = so3::exp({0.0, 0.1, -0.1}) * scene.direction();
      const EpipolarFit fit = fit_epipolar(R_gyro, pairs, 3.0 * start, kFocal_px, kLoose_rad);
      CHECK(fit.direction.norm() == doctest::Approx(1.0));
      CHECK(angle_rad(fit.direction, scene.direction()) < 1e-3);
      CHECK((fit.turn_rad - missed_rad).norm() < 1e-4);
    }
  }

  TEST_CASE("a direction that comes with the other sign keeps it") {
    const Scene scene;
    const Eigen::Vector3d start = -(so3::exp({0.05, 0.0, 0.0}) * scene.direction());
    const EpipolarFit fit =
        fit_epipolar(scene.R_to_from, scene.pairs(60, 0.0, 1), start, kFocal_px, kLoose_rad);
    CHECK(angle_rad(fit.direction, -scene.direction()) < 1e-3);
  }

  TEST_CASE("a sure gyro leaves the rotation alone") {
    const Scene scene;
    const Eigen::Matrix3d R_gyro = so3::exp({0.0, 0.004, 0.0}).toRotationMatrix() * scene.R_to_from;
    const EpipolarFit fit =
        fit_epipolar(R_gyro, scene.pairs(60, 0.0, 1), scene.direction(), kFocal_px, 1e-7);
    CHECK(fit.turn_rad.norm() < 1e-6);
  }

  TEST_CASE("with noise the error is about the least that noise allows") {
    const Scene scene;
    constexpr double kNoise_px = 0.2;
    constexpr std::size_t kPairs = 100;
    constexpr int kRuns = 100;
    double turn_square = 0.0;
    double direction_square = 0.0;
    double least_turn_square = 0.0;
    double least_direction_square = 0.0;
    for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
      const EpipolarFit fit = fit_epipolar(scene.R_to_from, scene.pairs(kPairs, kNoise_px, seed),
                                           scene.direction(), kFocal_px, kLoose_rad);
      turn_square += fit.turn_rad.squaredNorm() / kRuns;
      direction_square += std::pow(angle_rad(fit.direction, scene.direction()), 2) / kRuns;
      const Matrix5d least = least_covariance(scene, scene.pairs(kPairs, 0.0, seed), kNoise_px);
      least_turn_square += least.topLeftCorner<3, 3>().trace() / kRuns;
      least_direction_square += least.bottomRightCorner<2, 2>().trace() / kRuns;
    }
    MESSAGE("rms error of the turn " << std::sqrt(turn_square) << " rad, least "
                                     << std::sqrt(least_turn_square) << "; of the direction "
                                     << std::sqrt(direction_square) << " rad, least "
                                     << std::sqrt(least_direction_square));
    // Variances; 100 runs scatter by a seventh, and Cauchy weights cost a little.
    CHECK(turn_square < 1.6 * least_turn_square);
    CHECK(turn_square > 0.6 * least_turn_square);
    CHECK(direction_square < 1.6 * least_direction_square);
    CHECK(direction_square > 0.6 * least_direction_square);
  }

  TEST_CASE("what moves by itself hardly counts") {
    const Scene scene;
    double robust_rad = 0.0;
    double plain_rad = 0.0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const std::vector<BearingPair> pairs = scene.pairs(100, 0.2, seed, 33);
      const EpipolarFit fit =
          fit_epipolar(scene.R_to_from, pairs, so3::exp({0.0, 0.1, 0.0}) * scene.direction(),
                       kFocal_px, kLoose_rad);
      robust_rad += angle_rad(fit.direction, scene.direction()) / 20.0;
      plain_rad += plain_error_rad(scene, pairs) / 20.0;
    }
    MESSAGE("mean error of the direction, 33 of 100 pairs moving: "
            << robust_rad << " rad, plain least squares " << plain_rad);
    CHECK(robust_rad < 0.3 * plain_rad);
    CHECK(robust_rad < 0.05);
  }

  TEST_CASE("a camera that only turns has its rotation put right, and any direction") {
    Scene scene;
    scene.t_to_from.setZero();
    const Eigen::Vector3d missed_rad(0.003, 0.002, -0.004);
    const Eigen::Matrix3d R_gyro = so3::exp(-missed_rad).toRotationMatrix() * scene.R_to_from;
    const EpipolarFit fit = fit_epipolar(R_gyro, scene.pairs(60, 0.0, 1), Eigen::Vector3d::UnitX(),
                                         kFocal_px, kLoose_rad);
    CHECK(fit.direction.norm() == doctest::Approx(1.0));
    CHECK((fit.turn_rad - missed_rad).norm() < 1e-4);
  }

  TEST_CASE("nothing to fit, one point over and over, or a broken one give a sound answer") {
    const Scene scene;
    const Eigen::Vector3d start(0.0, 0.6, 0.8);
    const auto fitted = [&](const std::vector<BearingPair>& pairs) {
      return fit_epipolar(scene.R_to_from, pairs, 2.0 * start, kFocal_px, 0.01);
    };
    const EpipolarFit none = fitted({});
    CHECK((none.direction - start).norm() < 1e-12);
    CHECK(none.turn_rad.norm() == 0.0);

    const EpipolarFit one = fitted(std::vector<BearingPair>(50, scene.pairs(1, 0.0, 1).front()));
    CHECK(one.direction.allFinite());
    CHECK(one.direction.norm() == doctest::Approx(1.0));
    CHECK(one.turn_rad.allFinite());

    // A point where the epipole is has no line.
    const BearingPair at_epipole{0.0, 0.0, 0.0, 0.0};
    const EpipolarFit at = fit_epipolar(Eigen::Matrix3d::Identity(), std::vector{at_epipole},
                                        Eigen::Vector3d::UnitZ(), kFocal_px, 0.01);
    CHECK((at.direction - Eigen::Vector3d::UnitZ()).norm() < 1e-12);

    std::vector<BearingPair> broken = scene.pairs(60, 0.0, 1);
    broken[3].to_x = std::numeric_limits<double>::quiet_NaN();
    const EpipolarFit kept = fitted(broken);
    CHECK((kept.direction - start).norm() < 1e-12);
    CHECK(kept.turn_rad.norm() == 0.0);
  }
}

}  // namespace pled
