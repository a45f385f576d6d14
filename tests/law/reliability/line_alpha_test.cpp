// Eqs. (15) to (17): how much of a line's weight is temporal.
#include "pled_vins/reliability/line_alpha.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

namespace pled {
namespace {

using Eigen::Vector2d;

/// Unit vector at an angle to `to`, turned from +x to +y.
Vector2d at_degrees(double degrees) {
  const double a = degrees * std::numbers::pi / 180.0;
  return {std::cos(a), std::sin(a)};
}

}  // namespace

TEST_SUITE("reliability.line_alpha") {
  TEST_CASE("p_n is 1 across the line, 0 along it and one half at 45 degrees") {
    const Vector2d line(3.0, 4.0);
    const Vector2d across(-4.0, 3.0);
    CHECK(normal_flow_ratio(across, line, 0.0) == doctest::Approx(1.0));
    CHECK(normal_flow_ratio(line, line, 0.0) == doctest::Approx(0.0));
    CHECK(normal_flow_ratio(line + across, line, 0.0) == doctest::Approx(0.5));
    CHECK(normal_flow_ratio(-line + across, line, 0.0) == doctest::Approx(0.5));
    // |m_n| = 2, |m_t| = 1
    CHECK(normal_flow_ratio({1.0, -2.0}, {1.0, 0.0}, 0.1) == doctest::Approx(2.0 / 3.1));
    CHECK(normal_flow_ratio({0.0, 0.0}, line, 1e-9) == 0.0);
  }

  TEST_CASE("r is the cosine of gradient and motion, whatever their senses") {
    CHECK(gradient_alignment({2, 0}, {5, 0}, 0.0) == doctest::Approx(1.0));
    CHECK(gradient_alignment({2, 0}, {-5, 0}, 0.0) == doctest::Approx(1.0));
    CHECK(gradient_alignment({2, 0}, {0, 5}, 0.0) == doctest::Approx(0.0));
    CHECK(gradient_alignment(3 * at_degrees(20), 0.1 * at_degrees(65), 0.0) ==
          doctest::Approx(std::sqrt(0.5)));
    CHECK(gradient_alignment({0.1, 0}, {2, 0}, 0.05) == doctest::Approx(0.2 / 0.25));
    CHECK(gradient_alignment({0, 0}, {2, 0}, 1e-9) == 0.0);
  }

  TEST_CASE("alpha falls with p_n and rises with r") {
    CHECK(line_alpha(0.0, 0.0) == 1.0);
    CHECK(line_alpha(1.0, 0.0) == 0.0);
    CHECK(line_alpha(1.0, 1.0) == 1.0);
    CHECK(line_alpha(0.5, 0.4) == doctest::Approx(0.7));
  }

  TEST_CASE("with the gradient across the line, alpha is 1 at 0 and 90 degrees and never small") {
    // 1 - cos t / (cos t + sin t) (1 - cos t), t the motion's angle to the normal
    struct Row {
      double degrees, alpha;
    };
    const std::vector<Row> table{{0, 1.0},    {20, 0.956}, {40, 0.873}, {45, 0.8536},
                                 {60, 0.817}, {80, 0.876}, {90, 1.0}};
    for (const Row& row : table) {
      CAPTURE(row.degrees);
      // The line lies at 30 degrees, its normal at 120.
      const Vector2d line = 7.0 * at_degrees(30.0);
      const Vector2d gradient = 0.2 * at_degrees(120.0);
      const Vector2d motion = 4.0 * at_degrees(120.0 - row.degrees);
      CHECK(line_alpha(motion, line, gradient, ScoreForm::kPaper) ==
            doctest::Approx(row.alpha).epsilon(1e-3));
      CHECK(line_alpha(-motion, -line, -gradient, ScoreForm::kPaper) ==
            doctest::Approx(row.alpha).epsilon(1e-3));
      CHECK(line_alpha(motion, line, gradient, ScoreForm::kClean) ==
            doctest::Approx(row.alpha).epsilon(0.02));
    }
  }

  TEST_CASE("motion too short to have a direction leaves half; a flat q says nothing") {
    const Vector2d line(10, 0);
    CHECK(line_alpha({0.0, 0.49}, line, {0, 0.2}, ScoreForm::kClean) == 0.5);
    CHECK(line_alpha({0, 0}, line, {0, 0.2}, ScoreForm::kClean) == 0.5);
    // r = 0, p_n = 2 / 2.1
    CHECK(line_alpha({0, 2}, line, {0, 0.019}, ScoreForm::kClean) == doctest::Approx(1 - 2 / 2.1));
    CHECK(line_alpha({0, 2}, line, {0, 0}, ScoreForm::kClean) == doctest::Approx(1 - 2 / 2.1));
    // By the letter any motion and any gradient have a direction, and no motion is along the line.
    CHECK(line_alpha({0.0, 1e-3}, line, {0, 1e-3}, ScoreForm::kPaper) ==
          doctest::Approx(1.0).epsilon(1e-2));
    CHECK(line_alpha({0.0, 1e-3}, line, {1e-3, 0}, ScoreForm::kPaper) ==
          doctest::Approx(0.0).epsilon(1e-2));
    CHECK(line_alpha({0, 0}, line, {0, 0.2}, ScoreForm::kPaper) == 1.0);
    CHECK(line_alpha({0, 2}, line, {0, 0}, ScoreForm::kPaper) == doctest::Approx(0.0));
  }

  TEST_CASE("what is not finite, and a line without direction, have no alpha") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const ScoreForm form : {ScoreForm::kPaper, ScoreForm::kClean}) {
      CHECK(std::isnan(line_alpha({nan, 1}, {1, 0}, {0, 1}, form)));
      CHECK(std::isnan(line_alpha({1, 1}, {nan, 0}, {0, 1}, form)));
      CHECK(std::isnan(line_alpha({1, 1}, {1, 0}, {0, nan}, form)));
      CHECK(std::isnan(line_alpha({1, 1}, {0, 0}, {0, 1}, form)));
    }
  }

  TEST_CASE("a line's motion is what its ends left, and what points beside it went along it") {
    const std::array<Vector2d, 2> then{Vector2d(20, 30), Vector2d(60, 30)};
    // Slid by 5 px at one end and 3 px down; a real line's ends need not be the same.
    const std::array<Vector2d, 2> now{Vector2d(25, 33), Vector2d(60, 33)};
    const Vector2d by_ends = line_motion(then, now, true, {});
    CHECK(by_ends.x() == 0.0);  // longer or shorter by more than a tenth
    CHECK(by_ends.y() == doctest::Approx(3.0));
    const std::array<Vector2d, 2> shifted{Vector2d(24, 33), Vector2d(64, 33)};
    CHECK((line_motion(then, shifted, true, {}) - Vector2d(4, 3)).norm() < 1e-12);
    CHECK((line_motion(then, shifted, false, {}) - Vector2d(0, 3)).norm() < 1e-12);

    std::vector<PointMotion> points{{{40, 40}, {-6, 1}}, {{30, 10}, {-7, 9}}};
    CHECK((line_motion(then, shifted, true, points) - Vector2d(4, 3)).norm() < 1e-12);
    points.push_back({{40, 64}, {100, 100}});  // 31 px off
    CHECK((line_motion(then, shifted, true, points) - Vector2d(4, 3)).norm() < 1e-12);
    points.push_back({{93, 33}, {2, -20}});  // 29 px beyond an end
    CHECK((line_motion(then, shifted, true, points) - Vector2d(-6, 3)).norm() < 1e-12);
    points.push_back({{40, 33}, {std::nan(""), 0}});
    CHECK((line_motion(then, shifted, true, points) - Vector2d(-6, 3)).norm() < 1e-12);
  }

  TEST_CASE("a turned line has gone by what its middle has") {
    const std::array<Vector2d, 2> then{Vector2d(0, 0), Vector2d(40, 0)};
    const std::array<Vector2d, 2> now{Vector2d(0, 1), Vector2d(40, 3)};
    const Vector2d m = line_motion(then, now, false, {});
    const Vector2d normal = Vector2d(-2, 40).normalized();
    CHECK((m - 2.0 * normal).norm() < 1e-12);
    CHECK((line_motion({then[1], then[0]}, {now[1], now[0]}, false, {}) - m).norm() < 1e-12);
  }
}

}  // namespace pled
