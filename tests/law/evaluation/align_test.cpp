#include "pled_vins/evaluation/align.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Eigenvalues>
#include <doctest/doctest.h>

#include "pled_vins/evaluation/evaluate.hpp"

namespace {

using Points = std::vector<Eigen::Vector3d>;

Points random_points(std::mt19937_64& generator, std::size_t count, double size_m) {
  std::uniform_real_distribution<double> at(-size_m, size_m);
  Points points;
  for (std::size_t i = 0; i < count; ++i)
    points.emplace_back(at(generator), at(generator), at(generator));
  return points;
}

pled::Pose random_pose(std::mt19937_64& generator) {
  std::normal_distribution<double> n;
  pled::Pose pose;
  pose.q = Eigen::Quaterniond(n(generator), n(generator), n(generator), n(generator)).normalized();
  pose.p = {10 * n(generator), 10 * n(generator), 10 * n(generator)};
  return pose;
}

/// Horn, JOSA 1987: the rotation is the eigenvector of the largest eigenvalue of N.
pled::Pose align_by_horn(const Points& from, const Points& to) {
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    a += from[i] / static_cast<double>(from.size());
    b += to[i] / static_cast<double>(to.size());
  }
  Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) S += (from[i] - a) * (to[i] - b).transpose();
  Eigen::Matrix4d N;
  N << S(0, 0) + S(1, 1) + S(2, 2), S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0),  //
      S(1, 2) - S(2, 1), S(0, 0) - S(1, 1) - S(2, 2), S(0, 1) + S(1, 0), S(2, 0) + S(0, 2),   //
      S(2, 0) - S(0, 2), S(0, 1) + S(1, 0), -S(0, 0) + S(1, 1) - S(2, 2), S(1, 2) + S(2, 1),  //
      S(0, 1) - S(1, 0), S(2, 0) + S(0, 2), S(1, 2) + S(2, 1), -S(0, 0) - S(1, 1) + S(2, 2);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(N);
  const Eigen::Vector4d q = solver.eigenvectors().col(3);
  pled::Pose T;
  T.q = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized();
  T.p = b - T.q * a;
  return T;
}

TEST_SUITE("evaluation.align") {
  TEST_CASE("a known transform is recovered to rounding") {
    std::mt19937_64 generator(1);
    for (int run = 0; run < 50; ++run) {
      const pled::Pose T = random_pose(generator);
      const Points from = random_points(generator, 4 + static_cast<std::size_t>(run), 5.0);
      Points to;
      for (const Eigen::Vector3d& p : from) to.push_back(T * p);
      const pled::Pose found = pled::align_rigid(from, to);
      CHECK((found.R() - T.R()).norm() < 1e-12);
      CHECK((found.p - T.p).norm() < 1e-11);
    }
  }

  TEST_CASE("the result never mirrors, even when a mirror image would fit exactly") {
    std::mt19937_64 generator(2);
    const Points from = random_points(generator, 20, 3.0);
    Points to;
    for (const Eigen::Vector3d& p : from) to.emplace_back(p.x(), p.y(), -p.z());
    const pled::Pose found = pled::align_rigid(from, to);
    CHECK(found.R().determinant() == doctest::Approx(1.0));
    CHECK((found * from[0] - to[0]).norm() > 1e-3);
  }

  TEST_CASE("points in a plane are enough for one rotation") {
    std::mt19937_64 generator(3);
    Points from = random_points(generator, 10, 3.0);
    for (Eigen::Vector3d& p : from) p.z() = 0.0;
    const pled::Pose T = random_pose(generator);
    Points to;
    for (const Eigen::Vector3d& p : from) to.push_back(T * p);
    CHECK((pled::align_rigid(from, to).R() - T.R()).norm() < 1e-11);
  }

  TEST_CASE("Umeyama's SVD equals Horn's quaternion on noisy points to 1e-6") {
    std::mt19937_64 generator(4);
    std::normal_distribution<double> noise(0.0, 0.1);
    for (int run = 0; run < 50; ++run) {
      const pled::Pose T = random_pose(generator);
      const Points from = random_points(generator, 30, 4.0);
      Points to;
      for (const Eigen::Vector3d& p : from)
        to.push_back(T * p + Eigen::Vector3d(noise(generator), noise(generator), noise(generator)));
      const pled::Pose a = pled::align_rigid(from, to);
      const pled::Pose b = align_by_horn(from, to);
      for (const Eigen::Vector3d& p : from) CHECK((a * p - b * p).norm() < 1e-6);
    }
  }

  TEST_CASE("evaluate() equals an independent computation to 1e-6") {
    std::mt19937_64 generator(5);
    std::normal_distribution<double> noise(0.0, 0.05);
    const pled::Pose T = random_pose(generator);
    pled::Trajectory truth;
    pled::Trajectory estimate;
    Points from;
    Points to;
    double path_m = 0.0;
    for (int i = 0; i <= 200; ++i) {
      const double t = 0.05 * i;
      pled::Pose pose;
      pose.p = {std::cos(t), 2 * std::sin(t), 0.3 * t};
      pose.q = Eigen::AngleAxisd(t, Eigen::Vector3d(1, 2, 3).normalized());
      const std::int64_t stamp_ns = 50'000'000LL * i;
      if (i > 0) path_m += (pose.p - truth.back().pose.p).norm();
      truth.push_back({stamp_ns, pose});
      pled::Pose seen = T * pose;
      seen.p += Eigen::Vector3d(noise(generator), noise(generator), noise(generator));
      seen.q = (seen.q * Eigen::Quaterniond(1, noise(generator), 0, noise(generator))).normalized();
      estimate.push_back({stamp_ns, seen});
      from.push_back(seen.p);
      to.push_back(pose.p);
    }
    const pled::Pose align = align_by_horn(from, to);
    double sum = 0.0;
    double sum2 = 0.0;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const double e = (align * from[i] - to[i]).norm();
      sum += e;
      sum2 += e * e;
    }
    // 1 s is 20 frames of 50 ms. By 4 x 4 matrices, where evaluate() uses quaternions.
    double trans2 = 0.0;
    double rot2 = 0.0;
    const auto matrix = [](const pled::Pose& pose) {
      Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
      M.topLeftCorner<3, 3>() = pose.R();
      M.topRightCorner<3, 1>() = pose.p;
      return M;
    };
    const std::size_t pairs = truth.size() - 20;
    for (std::size_t i = 0; i < pairs; ++i) {
      const Eigen::Matrix4d q = matrix(truth[i].pose).inverse() * matrix(truth[i + 20].pose);
      const Eigen::Matrix4d p = matrix(estimate[i].pose).inverse() * matrix(estimate[i + 20].pose);
      const Eigen::Matrix4d e = q.inverse() * p;
      trans2 += e.topRightCorner<3, 1>().squaredNorm();
      const double angle = std::acos(std::min(1.0, (e.topLeftCorner<3, 3>().trace() - 1.0) / 2.0));
      rot2 += angle * angle;
    }
    const auto count = static_cast<double>(from.size());
    const pled::Evaluation e =
        pled::evaluate(estimate, truth, pled::FrameSpan{0, 10'000'000'000, 50'000'000});
    REQUIRE(e.ate_rmse_m);
    CHECK(std::abs(*e.ate_rmse_m - std::sqrt(sum2 / count)) < 1e-6);
    REQUIRE(e.mpe_percent);
    CHECK(std::abs(*e.mpe_percent - 100.0 * (sum / count) / path_m) < 1e-6);
    CHECK(e.rpe_pairs == pairs);
    REQUIRE(e.rpe_trans_m);
    CHECK(std::abs(*e.rpe_trans_m - std::sqrt(trans2 / static_cast<double>(pairs))) < 1e-6);
    REQUIRE(e.rpe_rot_deg);
    CHECK(std::abs(*e.rpe_rot_deg -
                   std::sqrt(rot2 / static_cast<double>(pairs)) * 180.0 / std::acos(-1.0)) < 1e-6);
    CHECK(e.coverage == 1.0);
  }
}

}  // namespace
