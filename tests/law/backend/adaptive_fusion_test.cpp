#include "pled_vins/backend/adaptive_fusion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/backend/robust_weight.hpp"

namespace pled {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr FusionConfig kPaperSettings{.mode = FusionMode::kPaper, .alpha0 = 0.4, .tau = 0.2};

/// What ten frames of five rounds each make of a track whose residuals sum up to S in every round:
/// the paper's loss with 2 and 0.2, one observation more a frame, each round's weight fused and
/// remembered for the next.
double after_ten_frames(double S, double z) {
  const RobustWeightConfig robust{RobustMode::kPaper, 2.0, 0.2};
  double w = 1.0;
  for (std::size_t observations = 1; observations <= 10; ++observations) {
    const std::vector<double> squared(observations, S / static_cast<double>(observations));
    for (int round = 0; round < 5; ++round) {
      const auto w_ba = robust_weight(robust, {.squared = squared, .previous = w});
      REQUIRE(w_ba.has_value());
      w = paper_point_fusion(*w_ba, z, kPaperSettings);
    }
  }
  return w;
}

}  // namespace

TEST_SUITE("backend.adaptive_fusion") {
  TEST_CASE("a point's weight goes towards z by alpha0 D exp(-D / tau), from either side") {
    struct Step {
      double difference, step;
    };
    // 0.4 D exp(-5 D), to four decimals.
    for (const Step& s :
         {Step{0.05, 0.0156}, Step{0.1, 0.0243}, Step{0.2, 0.0294}, Step{0.3, 0.0268},
          Step{0.5, 0.0164}, Step{0.7, 0.0085}, Step{1.0, 0.0027}}) {
      CAPTURE(s.difference);
      const double up = paper_point_fusion(0.0, s.difference, kPaperSettings);
      const double down = paper_point_fusion(1.0, 1.0 - s.difference, kPaperSettings);
      CHECK(std::abs(up - s.step) < 5.1e-5);
      CHECK(std::abs(1.0 - down - s.step) < 5.1e-5);
    }
  }

  TEST_CASE("no point moves more than alpha0 tau / e, which it does where the two differ by tau") {
    std::mt19937_64 random(60);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    for (int trial = 0; trial < 5000; ++trial) {
      const FusionConfig c{.alpha0 = share(random), .tau = 0.01 + share(random)};
      const double most = c.alpha0 * c.tau / std::numbers::e;
      const double w_ba = share(random), z = share(random);
      const double w = paper_point_fusion(w_ba, z, c);
      CHECK(std::abs(w - w_ba) <= most * (1 + 1e-12) + 1e-15);
      CHECK(w >= std::min(w_ba, z) - 1e-15);
      CHECK(w <= std::max(w_ba, z) + 1e-15);
      if (c.tau <= 1.0)
        CHECK(paper_point_fusion(0.0, c.tau, c) == doctest::Approx(most).epsilon(1e-12));
    }
  }

  TEST_CASE("rounds of weights and fusion settle where the paper's rule has its fixed points") {
    struct Point {
      double S, z, w;
    };
    // Two decimals, computed apart from this code; S = 0.5 looks at rest, 40 clearly moves.
    for (const Point& p :
         {Point{0.5, 0.7, 0.72}, Point{0.5, 0.95, 0.92}, Point{2, 0.5, 0.50}, Point{2, 0.7, 0.63},
          Point{2, 0.95, 0.63}, Point{8, 0.05, 0.13}, Point{8, 0.3, 0.255}, Point{8, 0.5, 0.285},
          Point{8, 0.7, 0.25}, Point{8, 0.95, 0.22}, Point{40, 0.05, 0.05}, Point{40, 0.3, 0.09},
          Point{40, 0.5, 0.08}, Point{40, 0.7, 0.06}, Point{40, 0.95, 0.05}}) {
      CAPTURE(p.S);
      CAPTURE(p.z);
      CHECK(std::abs(after_ten_frames(p.S, p.z) - p.w) < 0.0051);
    }
    // Time alone is overheard: what just started to move, by a z of 0.1, keeps its weight.
    CHECK(paper_point_fusion(0.9, 0.1, kPaperSettings) > 0.89);
  }

  TEST_CASE("a line's weight is the mean of the two, alpha_line the share of z") {
    CHECK(paper_line_fusion(0.8, 0.2, 0.0) == 0.8);
    CHECK(paper_line_fusion(0.8, 0.2, 1.0) == 0.2);
    CHECK(paper_line_fusion(0.8, 0.2, 0.25) == doctest::Approx(0.65).epsilon(1e-12));
    // A line that moves at 60 degrees to its normal, as its gradient tells: p_n = 1 / (1 + sqrt 3),
    // r = 1 / 2.
    const double alpha = 1.0 - 1.0 / (1.0 + std::numbers::sqrt3) * 0.5;
    CHECK(std::abs(alpha - 0.817) < 5e-4);
    CHECK(paper_line_fusion(1.0, 0.0, alpha) == doctest::Approx(1.0 - alpha).epsilon(1e-12));
  }

  TEST_CASE("without evidence of time the weight of geometry stays to the bit") {
    for (const double w : {0.0, 0.1 + 0.2, 1.0}) {
      CHECK(paper_point_fusion(w, kNan, kPaperSettings) == w);
      CHECK(paper_line_fusion(w, kNan, 0.7) == w);
      CHECK(paper_line_fusion(w, 0.3, kNan) == w);
    }
  }
}

}  // namespace pled
