#include "pled_vins/geometry/camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/geometry/undistortion_table.hpp"

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using pled::Camera;
using pled::CameraCalibration;
using pled::Distortion;

CameraCalibration calibration(int width_px, int height_px, double fx_px, double fy_px, double cx_px,
                              double cy_px, Distortion distortion,
                              const std::array<double, 5>& coeffs) {
  CameraCalibration c;
  c.width_px = width_px;
  c.height_px = height_px;
  c.fx_px = fx_px;
  c.fy_px = fy_px;
  c.cx_px = cx_px;
  c.cy_px = cy_px;
  c.distortion = distortion;
  c.coeffs = coeffs;
  return c;
}

struct Named {
  std::string name;
  CameraCalibration c;
};

/// Published calibrations of the sensors this estimator is used with.
std::vector<Named> typical() {
  return {
      {"davis240c", calibration(240, 180, 199.092, 198.829, 132.192, 110.713, Distortion::kRadtan,
                                {-0.368436, 0.150947, -0.000296, -0.000759, 0.0})},
      {"euroc cam0", calibration(752, 480, 458.654, 457.296, 367.215, 248.375, Distortion::kRadtan,
                                 {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0})},
      {"dsec", calibration(640, 480, 553.469, 553.399, 346.653, 216.521, Distortion::kRadtan,
                           {-0.0936, 0.1945, 7.6e-05, 0.00196, 0.0})},
      {"davis equidistant",
       calibration(240, 180, 197.89, 197.777, 130.68, 111.161, Distortion::kEquidistant,
                   {-0.0799, 0.1468, -0.2321, 0.1334, 0.0})},
      {"viode", calibration(752, 480, 376.0, 376.0, 376.0, 240.0, Distortion::kNone, {})}};
}

/// The distortion formulas, written out as OpenCV's and Kalibr's documents do.
Vector2d distort_by_definition(const CameraCalibration& c, const Vector2d& p) {
  const auto& k = c.coeffs;
  const double x = p.x();
  const double y = p.y();
  const double r = p.norm();
  Vector2d d = p;
  if (c.distortion == Distortion::kRadtan) {
    const double radial =
        1.0 + k[0] * std::pow(r, 2) + k[1] * std::pow(r, 4) + k[4] * std::pow(r, 6);
    d = {x * radial + 2.0 * k[2] * x * y + k[3] * (r * r + 2.0 * x * x),
         y * radial + k[2] * (r * r + 2.0 * y * y) + 2.0 * k[3] * x * y};
  } else if (c.distortion == Distortion::kEquidistant) {
    const double a = std::atan(r);
    const double a_d = a * (1.0 + k[0] * std::pow(a, 2) + k[1] * std::pow(a, 4) +
                            k[2] * std::pow(a, 6) + k[3] * std::pow(a, 8));
    d = r > 0.0 ? Vector2d(p * (a_d / r)) : p;
  }
  return {c.fx_px * d.x() + c.cx_px, c.fy_px * d.y() + c.cy_px};
}

}  // namespace

TEST_SUITE("geometry.camera") {
  TEST_CASE("distort equals the published formula, near the axis too") {
    for (const Named& n : typical()) {
      CAPTURE(n.name);
      const Camera camera(n.c);
      for (const double r : {0.0, 1e-9, 1e-5, 0.9e-3, 1.1e-3, 0.01, 0.1, 0.4, 0.7}) {
        for (const double angle : {0.0, 0.7, 2.0, 4.0}) {
          CAPTURE(r);
          const Vector2d p(r * std::cos(angle), r * std::sin(angle));
          CHECK((camera.distort(p) - distort_by_definition(n.c, p)).norm() < 1e-11);
        }
      }
    }
  }

  TEST_CASE("the Jacobian of distort is its central difference") {
    constexpr double kStep = 1e-6;
    for (const Named& n : typical()) {
      CAPTURE(n.name);
      const Camera camera(n.c);
      for (const Vector2d& p :
           {Vector2d(0.0, 0.0), Vector2d(1e-4, -2e-4), Vector2d(0.3, -0.2), Vector2d(-0.5, 0.4)}) {
        Matrix2d J = Matrix2d::Constant(std::numeric_limits<double>::quiet_NaN());
        const Vector2d px = camera.distort(p, J);
        CHECK((px - camera.distort(p)).norm() == 0.0);
        for (int k = 0; k < 2; ++k) {
          const Vector2d d = kStep * Vector2d::Unit(k);
          const Vector2d want = (camera.distort(p + d) - camera.distort(p - d)) / (2.0 * kStep);
          // Rounding of pixels (1e-13) over the step, and the step's third-order error.
          CHECK((J.col(k) - want).norm() < 1e-6);
        }
      }
    }
  }

  TEST_CASE("distort after undistort gives every pixel of every typical sensor back") {
    for (const Named& n : typical()) {
      CAPTURE(n.name);
      const Camera camera(n.c);
      int missing = 0;
      double worst_px = 0.0;
      for (int y = 0; y < n.c.height_px; y += 3) {
        for (int x = 0; x < n.c.width_px; x += 3) {
          const Vector2d raw(x, y);
          const auto p = camera.undistort(raw);
          if (!p) {
            ++missing;
            continue;
          }
          worst_px = std::max(worst_px, (camera.distort(*p) - raw).norm());
        }
      }
      CHECK(missing == 0);
      CHECK(worst_px < 1e-9 * n.c.fx_px);
    }
  }

  TEST_CASE("undistort after project gives the bearing back inside the turning radius") {
    for (const Named& n : typical()) {
      CAPTURE(n.name);
      const Camera camera(n.c);
      for (const double r : {0.0, 0.01, 0.2, 0.5, 0.8}) {
        if (!(r < 0.95 * camera.turning_radius())) continue;
        const Vector2d p(r * 0.8, r * 0.6);
        const auto px = camera.project(Vector3d(3.0 * p.x(), 3.0 * p.y(), 3.0));
        REQUIRE(px.has_value());
        const auto back = camera.undistort(*px);
        REQUIRE(back.has_value());
        CHECK((*back - p).norm() < 1e-8);
      }
    }
  }

  TEST_CASE("the turning radius is where the radial slope is zero") {
    // 1 - 3 * 0.3 r^2 = 0.
    const Camera camera(
        calibration(640, 480, 300, 300, 320, 240, Distortion::kRadtan, {-0.3, 0.0, 0.0, 0.0, 0.0}));
    CHECK(camera.turning_radius() == doctest::Approx(std::sqrt(1.0 / 0.9)).epsilon(1e-9));
  }

  TEST_CASE("a lens that folds back projects nothing beyond its turning radius") {
    const Camera camera(
        calibration(640, 480, 300, 300, 320, 240, Distortion::kRadtan, {-0.3, 0.0, 0.0, 0.0, 0.0}));
    CHECK(camera.project({0.99 * camera.turning_radius(), 0.0, 1.0}).has_value());
    CHECK_FALSE(camera.project({1.01 * camera.turning_radius(), 0.0, 1.0}).has_value());
    // The point at three times the radius folds back into the image: its pixel has another bearing.
    const Vector2d folded = camera.distort({1.7, 0.0});
    REQUIRE(camera.inside(folded));
    const auto p = camera.undistort(folded);
    REQUIRE(p.has_value());
    CHECK(p->norm() < camera.turning_radius());
    CHECK((camera.distort(*p) - folded).norm() < 1e-6);
  }

  TEST_CASE("pixels that no bearing reaches are refused") {
    const Camera radtan(
        calibration(640, 480, 300, 300, 320, 240, Distortion::kRadtan, {-0.3, 0.0, 0.0, 0.0, 0.0}));
    const double edge_px = radtan.distort({radtan.turning_radius(), 0.0}).x();
    CHECK(radtan.undistort({edge_px - 1.0, 240.0}).has_value());
    CHECK_FALSE(radtan.undistort({edge_px + 1.0, 240.0}).has_value());
    CHECK_FALSE(radtan.undistort({1e6, -1e6}).has_value());
    const Camera equidistant(typical()[3].c);
    CHECK_FALSE(equidistant.undistort({1e4, 0.0}).has_value());
  }

  TEST_CASE("points at or behind the camera and values that are not finite are refused") {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    for (const Named& n : typical()) {
      CAPTURE(n.name);
      const Camera camera(n.c);
      CHECK_FALSE(camera.project({0.0, 0.0, 0.0}).has_value());
      CHECK_FALSE(camera.project({0.1, 0.1, -1.0}).has_value());
      CHECK_FALSE(camera.project({0.1, 0.1, kNaN}).has_value());
      CHECK_FALSE(camera.project({kNaN, 0.1, 1.0}).has_value());
      CHECK_FALSE(camera.undistort({kNaN, 1.0}).has_value());
    }
  }
}

TEST_SUITE("geometry.undistortion_table") {
  TEST_CASE("at equals Camera::undistort to single precision at every pixel") {
    for (const Named& n : typical()) {
      CAPTURE(n.name);
      const Camera camera(n.c);
      std::vector<float> storage(
          pled::UndistortionTable::floats_needed(n.c.width_px, n.c.height_px),
          std::numeric_limits<float>::quiet_NaN());
      pled::UndistortionTable table;
      REQUIRE(table.build(camera, storage));
      CHECK(table.invalid_pixels() == 0);
      double worst = 0.0;
      for (int y = 0; y < n.c.height_px; y += 7) {
        for (int x = 0; x < n.c.width_px; x += 7) {
          const auto b = table.at(x, y);
          REQUIRE(b.has_value());
          worst = std::max(worst, (b->cast<double>() - *camera.undistort(Vector2d(x, y))).norm());
        }
      }
      CHECK(worst < 2e-7);  // 2^-24 of values up to 2
    }
  }

  TEST_CASE("bilinear lookup is within 0.01 px of Camera::undistort between pixels") {
    // Its error is at most 1/8 of the bearing's second differences over one pixel.
    for (const Named& n : typical()) {
      CAPTURE(n.name);
      const Camera camera(n.c);
      std::vector<float> storage(
          pled::UndistortionTable::floats_needed(n.c.width_px, n.c.height_px));
      pled::UndistortionTable table;
      REQUIRE(table.build(camera, storage));
      double worst_px = 0.0;
      for (double y = 0.0; y <= n.c.height_px - 1; y += 4.37) {
        for (double x = 0.0; x <= n.c.width_px - 1; x += 4.61) {
          const auto b = table.lookup(static_cast<float>(x), static_cast<float>(y));
          REQUIRE(b.has_value());
          worst_px = std::max(
              worst_px, n.c.fx_px * (b->cast<double>() - *camera.undistort(Vector2d(x, y))).norm());
        }
      }
      MESSAGE(n.name << ": worst " << worst_px << " px");
      CHECK(worst_px < 0.01);
    }
  }

  TEST_CASE("the last pixel can be looked up, and nothing beyond it") {
    const Named n = typical()[0];
    std::vector<float> storage(pled::UndistortionTable::floats_needed(240, 180));
    pled::UndistortionTable table;
    REQUIRE(table.build(Camera(n.c), storage));
    CHECK(table.lookup(239.0F, 179.0F).has_value());
    CHECK(table.lookup(0.0F, 0.0F).has_value());
    CHECK_FALSE(table.lookup(239.01F, 10.0F).has_value());
    CHECK_FALSE(table.lookup(-0.01F, 10.0F).has_value());
    CHECK_FALSE(table.lookup(std::numeric_limits<float>::quiet_NaN(), 10.0F).has_value());
    CHECK_FALSE(table.at(240, 0).has_value());
    CHECK_FALSE(table.at(0, -1).has_value());
    CHECK_FALSE(table.at(0, 180).has_value());
  }

  TEST_CASE("pixels outside the lens model are marked, and so are their neighbours' gaps") {
    // The image circle ends at 0.7027 * 100 = 70.27 px from the centre.
    const CameraCalibration c =
        calibration(201, 201, 100, 100, 100, 100, Distortion::kRadtan, {-0.3, 0.0, 0.0, 0.0, 0.0});
    std::vector<float> storage(pled::UndistortionTable::floats_needed(201, 201));
    pled::UndistortionTable table;
    REQUIRE(table.build(Camera(c), storage));
    CHECK(table.at(170, 100).has_value());
    CHECK_FALSE(table.at(171, 100).has_value());
    CHECK(table.lookup(169.5F, 100.0F).has_value());
    CHECK_FALSE(table.lookup(170.5F, 100.0F).has_value());
    std::size_t invalid = 0;
    for (int y = 0; y < 201; ++y) {
      for (int x = 0; x < 201; ++x) invalid += table.at(x, y) ? 0U : 1U;
    }
    CHECK(invalid == table.invalid_pixels());
    CHECK(static_cast<double>(201 * 201 - invalid) ==
          doctest::Approx(std::numbers::pi * 70.27 * 70.27).epsilon(0.01));
  }

  TEST_CASE("storage that is too small is refused and left alone") {
    std::vector<float> storage(pled::UndistortionTable::floats_needed(240, 180) - 1, 7.0F);
    pled::UndistortionTable table;
    CHECK_FALSE(table.build(Camera(typical()[0].c), storage));
    CHECK(table.width_px() == 0);
    CHECK_FALSE(table.at(0, 0).has_value());
    for (const float f : storage) REQUIRE(f == 7.0F);
  }
}
