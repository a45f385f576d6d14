#include "pled_vins/geometry/line_triangulation.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/LU>
#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using pled::LineTriangulationRules;
using pled::OrthonormalLine;
using pled::PluckerLine;
using pled::Pose;
using pled::SegmentView;
using pled::triangulate_line;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Vector3d random_vector(std::mt19937_64& random, double scale) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random), z = normal(random);
  return scale * Vector3d(x, y, z);
}

/// A segment in space.
struct Segment {
  Vector3d a, b;
};

Vector2d picture(const Pose& T_world_cam, const Vector3d& p_world) {
  const Vector3d p = T_world_cam.inverse() * p_world;
  REQUIRE(p.z() > 0.0);
  return p.head<2>() / p.z();
}

SegmentView see(const Pose& T_world_cam, const Segment& segment) {
  return {T_world_cam, picture(T_world_cam, segment.a), picture(T_world_cam, segment.b)};
}

Pose at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }

/// Cameras near the origin of some frame that look along its z axis.
struct Flight {
  Pose T_world_frame;
  std::vector<Pose> cameras;
};

Flight random_flight(std::mt19937_64& random, int n, double spread_m) {
  Flight flight;
  flight.T_world_frame = {pled::so3::exp(random_vector(random, 1.0)), random_vector(random, 20.0)};
  for (int i = 0; i < n; ++i) {
    const Vector3d turn = random_vector(random, 0.05);
    flight.cameras.push_back(flight.T_world_frame *
                             Pose{pled::so3::exp(turn), random_vector(random, spread_m)});
  }
  return flight;
}

Segment random_segment(std::mt19937_64& random, const Flight& flight, double depth_m) {
  const Vector3d middle(0.1 * depth_m, -0.05 * depth_m, depth_m);
  const Vector3d half = 0.2 * depth_m * random_vector(random, 1.0).normalized();
  return {flight.T_world_frame * (middle - half), flight.T_world_frame * (middle + half)};
}

std::vector<SegmentView> views_of(const std::vector<Pose>& cameras, const Segment& segment) {
  std::vector<SegmentView> out;
  for (const Pose& T : cameras) out.push_back(see(T, segment));
  return out;
}

void add_noise(std::vector<SegmentView>& views, double sigma, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0.0, sigma);
  for (SegmentView& v : views) {
    for (int k = 0; k < 2; ++k) {
      v.start_xy[k] += normal(random);
      v.end_xy[k] += normal(random);
    }
  }
}

double distance(const PluckerLine& line, const Vector3d& p) {
  return (line.n - p.cross(line.d)).norm() / line.d.norm();
}

/// Residuals of all ends: their distances to the line's pictures.
Eigen::VectorXd residuals(const std::vector<SegmentView>& views, const PluckerLine& line) {
  Eigen::VectorXd r(2 * static_cast<Eigen::Index>(views.size()));
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto l = pled::project(views[i].T_world_cam.inverse() * line);
    REQUIRE(l.has_value());
    r[2 * static_cast<Eigen::Index>(i)] = l->dot(views[i].start_xy.homogeneous());
    r[2 * static_cast<Eigen::Index>(i) + 1] = l->dot(views[i].end_xy.homogeneous());
  }
  return r;
}

/// J^T J of the residuals by the four freedoms of the line, by central differences.
Eigen::Matrix4d information(const std::vector<SegmentView>& views, const OrthonormalLine& line) {
  constexpr double kStep = 1e-6;
  Eigen::MatrixXd J(2 * static_cast<Eigen::Index>(views.size()), 4);
  for (int k = 0; k < 4; ++k) {
    pled::LineTangent h = pled::LineTangent::Zero();
    h[k] = kStep;
    J.col(k) = (residuals(views, pled::to_plucker(box_plus(line, h))) -
                residuals(views, pled::to_plucker(box_plus(line, -h)))) /
               (2 * kStep);
  }
  return J.transpose() * J;
}

/// Rules that let everything pass that can be computed at all.
constexpr LineTriangulationRules kLenient{.sigma_xy = 1e-9, .min_angle_rad = 1e-7};

}  // namespace

TEST_SUITE("geometry.line_triangulation") {
  TEST_CASE("exact ends give the exact line, from 2 to 32 views, near and far") {
    std::mt19937_64 random(21);
    for (const int n : {2, 3, 8, 32}) {
      for (const double depth_m : {1.0, 5.0, 50.0}) {
        for (int trial = 0; trial < 50; ++trial) {
          CAPTURE(n);
          CAPTURE(depth_m);
          const Flight flight = random_flight(random, n, 0.05 * depth_m);
          const Segment segment = random_segment(random, flight, depth_m);
          const auto got = triangulate_line(views_of(flight.cameras, segment), kLenient);
          REQUIRE(got.has_value());
          // Two cameras by chance nearly in one plane with the line lose digits.
          const double exact_m = 1e-11 * depth_m / (got->angle_rad * got->angle_rad);
          CHECK(distance(got->line_world, segment.a) < exact_m);
          CHECK(distance(got->line_world, segment.b) < exact_m);
          CHECK(got->line_world.d.norm() == doctest::Approx(1.0).epsilon(1e-12));
          CHECK(std::abs(got->line_world.n.dot(got->line_world.d)) < 1e-11);
          CHECK((got->start_world - segment.a).norm() < 10 * exact_m);
          CHECK((got->end_world - segment.b).norm() < 10 * exact_m);
          CHECK(got->rms_error < 1e-12);
        }
      }
    }
  }

  TEST_CASE("views of other pieces with swapped ends give the same line") {
    std::mt19937_64 random(22);
    for (int trial = 0; trial < 100; ++trial) {
      const Flight flight = random_flight(random, 6, 0.3);
      const Segment whole = random_segment(random, flight, 4.0);
      std::uniform_real_distribution<double> share(0.0, 1.0);
      std::vector<SegmentView> views;
      for (const Pose& T : flight.cameras) {
        const double s = share(random), t = share(random);
        views.push_back(
            see(T, {whole.a + s * (whole.b - whole.a), whole.a + t * (whole.b - whole.a)}));
      }
      const auto got = triangulate_line(views, kLenient);
      REQUIRE(got.has_value());
      CHECK(distance(got->line_world, whole.a) < 1e-8);
      CHECK(distance(got->line_world, whole.b) < 1e-8);
      for (std::size_t i = 0; i < views.size(); ++i) {
        CHECK((views[got->view].end_xy - views[got->view].start_xy).norm() >=
              (views[i].end_xy - views[i].start_xy).norm());
      }
    }
  }

  TEST_CASE("the angle is the largest between the planes of two cameras with the line") {
    // A line along x, 2 m ahead; the planes turn with the camera's height.
    const Segment segment{{-1, 0, 2}, {1, 0, 2}};
    const auto got = triangulate_line(
        views_of({at(0, 0, 0), at(0.3, 0.1, 0), at(-0.2, 1.0, 0)}, segment), kLenient);
    REQUIRE(got.has_value());
    CHECK(got->angle_rad == doctest::Approx(std::atan2(1.0, 2.0)).epsilon(1e-9));
  }

  TEST_CASE("with noise the line is a minimum of the distances") {
    std::mt19937_64 random(23);
    int solved = 0;
    for (int trial = 0; trial < 50; ++trial) {
      const Flight flight = random_flight(random, 8, 0.4);
      auto views = views_of(flight.cameras, random_segment(random, flight, 4.0));
      add_noise(views, 0.003, random);
      const auto got = triangulate_line(views, {.sigma_xy = 0.003});
      if (!got) continue;
      ++solved;
      const double least = residuals(views, got->line_world).squaredNorm();
      CHECK(got->rms_error == doctest::Approx(std::sqrt(least / 16.0)).epsilon(1e-6));
      const auto held = pled::to_orthonormal(got->line_world);
      REQUIRE(held.has_value());
      const Eigen::Matrix4d H = information(views, *held);
      for (int k = 0; k < 4; ++k) {
        for (const double sigmas : {-0.3, 0.3}) {
          pled::LineTangent h = pled::LineTangent::Zero();
          h[k] = sigmas * 0.003 / std::sqrt(H(k, k));
          CHECK(residuals(views, pled::to_plucker(box_plus(*held, h))).squaredNorm() > least);
        }
      }
    }
    CHECK(solved > 30);
  }

  TEST_CASE("errors are as large as the Cramer-Rao bound says, and the depth's as reported") {
    constexpr double kSigma = 0.001;  // 0.2 px at f = 200 px
    constexpr int kTrials = 400;
    std::mt19937_64 random(24);
    double nees = 0.0, depth_nees = 0.0;
    int solved = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const Flight flight = random_flight(random, 8, 0.4);
      const Segment segment = random_segment(random, flight, 4.0);
      // The origin in the first camera, where no line that it sees passes.
      const Pose T_first_world = flight.cameras[0].inverse();
      std::vector<Pose> cameras;
      for (const Pose& T : flight.cameras) cameras.push_back(T_first_world * T);
      const Segment here{T_first_world * segment.a, T_first_world * segment.b};
      auto views = views_of(cameras, here);
      const auto truth = pled::to_orthonormal(pled::line_through(here.a, here.b));
      REQUIRE(truth.has_value());
      const Eigen::Matrix4d H = information(views, *truth) / (kSigma * kSigma);
      add_noise(views, kSigma, random);
      const auto got = triangulate_line(views, {.sigma_xy = kSigma});
      if (!got) continue;
      ++solved;
      PluckerLine line = got->line_world;
      if (line.n.dot(pled::to_plucker(*truth).n) < 0.0) line = {-line.n, -line.d};
      const auto held = pled::to_orthonormal(line);
      REQUIRE(held.has_value());
      const pled::LineTangent error = box_minus(*held, *truth);
      nees += error.dot(H * error);
      // Depths of the ends where the reference sees them on the true line.
      const Pose T_cam_world = cameras[got->view].inverse();
      const PluckerLine true_cam = T_cam_world * pled::line_through(here.a, here.b);
      const auto start = pled::point_seen_at(true_cam, views[got->view].start_xy);
      const auto end = pled::point_seen_at(true_cam, views[got->view].end_xy);
      REQUIRE(start.has_value());
      REQUIRE(end.has_value());
      const double rho1 = 1.0 / start->z(), rho2 = 1.0 / end->z();
      const double e1 = 1.0 / (T_cam_world * got->start_world).z() - rho1;
      const double e2 = 1.0 / (T_cam_world * got->end_world).z() - rho2;
      const double sigma = got->depth_sigma * std::max(rho1, rho2);
      depth_nees += std::max(e1 * e1, e2 * e2) / (sigma * sigma);
    }
    CHECK(solved > kTrials * 9 / 10);
    // Chi-square with 4 freedoms each: mean 4, standard deviation of the mean sqrt(8 / n).
    const double bound = 4.0 * std::sqrt(8.0 / solved);
    CHECK(nees / solved == doctest::Approx(4.0).epsilon(bound / 4.0));
    // The larger of two errors, the worse of which has one sigma: between one and the sum of two.
    CHECK(depth_nees / solved > 0.7);
    CHECK(depth_nees / solved < 2.0);
    MESSAGE("NEES " << nees / solved << " of 4 in " << solved << " lines; depth "
                    << depth_nees / solved);
  }

  TEST_CASE("motion along the line is refused, noise or not, and the same across it is not") {
    std::mt19937_64 random(25);
    const Segment segment{{-1, 0.4, 4}, {1, 0.4, 4}};
    std::vector<Pose> cameras, crossing;
    for (int i = 0; i < 8; ++i) {
      const Vector3d turn = random_vector(random, 0.05);
      cameras.push_back({pled::so3::exp(turn), Vector3d(0.1 * i, 0, 0)});
      crossing.push_back({pled::so3::exp(turn), Vector3d(0, 0.1 * i, 0)});
    }
    CHECK_FALSE(triangulate_line(views_of(cameras, segment), kLenient).has_value());
    int accepted = 0, accepted_across = 0;
    for (int trial = 0; trial < 500; ++trial) {
      auto views = views_of(cameras, segment);
      add_noise(views, 0.005, random);
      accepted += triangulate_line(views).has_value() ? 1 : 0;
      auto across = views_of(crossing, segment);
      add_noise(across, 0.005, random);
      accepted_across += triangulate_line(across).has_value() ? 1 : 0;
    }
    CHECK(accepted <= 2);
    CHECK(accepted_across >= 495);
    MESSAGE("accepted with noise: " << accepted << " of 500 along, " << accepted_across
                                    << " across");
  }

  TEST_CASE("motion in the plane of the line, towards it, is refused, noise or not") {
    std::mt19937_64 random(26);
    const Segment segment{{-1, 0.4, 4}, {1, 0.3, 4.5}};
    const Vector3d towards = 0.5 * (segment.a + segment.b).normalized();
    std::vector<Pose> cameras;
    for (int i = 0; i < 8; ++i) {
      const Vector3d turn = random_vector(random, 0.05);
      cameras.push_back({pled::so3::exp(turn), towards * (0.2 * i)});
    }
    CHECK_FALSE(triangulate_line(views_of(cameras, segment), kLenient).has_value());
    int accepted = 0;
    for (int trial = 0; trial < 500; ++trial) {
      auto views = views_of(cameras, segment);
      add_noise(views, 0.005, random);
      accepted += triangulate_line(views).has_value() ? 1 : 0;
    }
    CHECK(accepted <= 2);
    MESSAGE("accepted with noise: " << accepted << " of 500");
  }

  TEST_CASE("rotation alone is refused, noise or not") {
    std::mt19937_64 random(27);
    const Segment segment{{-1, 0.4, 4}, {1, 0.3, 4.5}};
    int accepted = 0;
    for (int trial = 0; trial < 200; ++trial) {
      std::vector<Pose> cameras;
      for (int i = 0; i < 8; ++i) {
        const Vector3d turn = random_vector(random, 0.1);
        cameras.push_back({pled::so3::exp(turn), Vector3d::Zero()});
      }
      auto views = views_of(cameras, segment);
      accepted += triangulate_line(views, kLenient).has_value() ? 1 : 0;
      add_noise(views, 0.005, random);
      accepted += triangulate_line(views).has_value() ? 1 : 0;
    }
    CHECK(accepted == 0);
  }

  TEST_CASE("planes at too small an angle and depths too uncertain are refused") {
    const Segment segment{{-1, 0, 4}, {1, 0.2, 4}};
    const auto views = views_of({at(0, 0, 0), at(0, 0.02, 0)}, segment);
    CHECK(triangulate_line(views, kLenient).has_value());
    // asin(0.02 / 4) = 0.29 deg; across the line, which leans by 0.1: 0.005 cos(atan 0.1).
    CHECK_FALSE(triangulate_line(views, {.sigma_xy = 1e-9, .min_angle_rad = 0.0050}).has_value());
    CHECK(triangulate_line(views, {.sigma_xy = 1e-9, .min_angle_rad = 0.0049}).has_value());
    CHECK_FALSE(triangulate_line(views).has_value());  // 5 mrad parallax with 5 mrad of noise
    // Parallel planes, a line at infinity: the same picture from two places.
    const SegmentView here{at(0, 0, 0), {-0.3, 0.1}, {0.3, 0.1}};
    const SegmentView beside{at(0, 0.5, 0), {-0.3, 0.1}, {0.3, 0.1}};
    CHECK_FALSE(triangulate_line(std::vector{here, beside}, kLenient).has_value());
  }

  TEST_CASE("a line behind the cameras is refused") {
    // The line y = 0.2, z = -4 has a picture in cameras that look along +z.
    const auto behind = [](const Pose& T) {
      const Vector3d a = T.inverse() * Vector3d(-1, 0.2, -4);
      const Vector3d b = T.inverse() * Vector3d(1, 0.2, -4);
      return SegmentView{T, a.head<2>() / a.z(), b.head<2>() / b.z()};
    };
    CHECK_FALSE(triangulate_line(std::vector{behind(at(0, 0, 0)), behind(at(0, 0.5, 0))}, kLenient)
                    .has_value());
  }

  TEST_CASE("a line that runs away to its vanishing point is found") {
    std::mt19937_64 random(28);
    int solved = 0;
    for (int trial = 0; trial < 50; ++trial) {
      std::vector<Pose> cameras;
      for (int i = 0; i < 8; ++i) cameras.push_back(at(0.1 * i, 0, 0.3 * i));
      auto views = views_of(cameras, {{-1, 1, 3.5}, {-1, 1, 40}});
      add_noise(views, 0.001, random);
      const auto got = triangulate_line(views, {.sigma_xy = 0.001});
      if (!got) continue;
      ++solved;
      CHECK(distance(got->line_world, {-1, 1, 3.5}) < 0.1);
      CHECK(std::abs(got->line_world.d.z()) > 0.995);
    }
    CHECK(solved >= 45);
  }

  TEST_CASE("too few or too many views, points for segments, wrong rules and NaN are refused") {
    std::mt19937_64 random(29);
    const Flight flight = random_flight(random, 33, 0.3);
    const Segment segment = random_segment(random, flight, 4.0);
    const auto many = views_of(flight.cameras, segment);
    CHECK_FALSE(triangulate_line(many, kLenient).has_value());
    const std::vector<SegmentView> some(many.begin(), many.begin() + 4);
    CHECK(triangulate_line(some, kLenient).has_value());
    CHECK_FALSE(triangulate_line(std::span(some).first(1), kLenient).has_value());
    CHECK_FALSE(triangulate_line({}, kLenient).has_value());
    auto points = some;
    for (SegmentView& v : points) v.end_xy = v.start_xy;
    CHECK_FALSE(triangulate_line(points, kLenient).has_value());
    for (const double bad : {0.0, -1.0, kNan}) {
      CHECK_FALSE(triangulate_line(some, {.sigma_xy = bad}).has_value());
      CHECK_FALSE(triangulate_line(some, {.min_angle_rad = bad}).has_value());
      CHECK_FALSE(triangulate_line(some, {.min_baseline_sigmas = bad}).has_value());
      CHECK_FALSE(triangulate_line(some, {.max_depth_sigma = bad}).has_value());
    }
    for (const double bad : {kNan, std::numeric_limits<double>::infinity()}) {
      for (std::size_t i = 0; i < some.size(); ++i) {
        auto wrong = some;
        wrong[i].start_xy.x() = bad;
        CHECK_FALSE(triangulate_line(wrong, kLenient).has_value());
        wrong = some;
        wrong[i].end_xy.y() = bad;
        CHECK_FALSE(triangulate_line(wrong, kLenient).has_value());
        wrong = some;
        wrong[i].T_world_cam.p.z() = bad;
        CHECK_FALSE(triangulate_line(wrong, kLenient).has_value());
        wrong = some;
        wrong[i].T_world_cam.q.x() = bad;
        CHECK_FALSE(triangulate_line(wrong, kLenient).has_value());
      }
    }
  }
}
