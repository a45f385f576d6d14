#include "pled_vins/backend/robust_weight.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

namespace pled {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
/// Those that choose a weight.
constexpr std::array kModes{RobustMode::kPerObservation, RobustMode::kPaper, RobustMode::kDynavins};
constexpr std::array kAllModes{RobustMode::kNone, RobustMode::kPerObservation, RobustMode::kPaper,
                               RobustMode::kDynavins};

double huber(double s) { return s <= 1.0 ? s : 2.0 * std::sqrt(s) - 1.0; }

/// The loss as the header writes it, term by term.
double by_definition(const RobustWeightConfig& c, const RobustEvidence& e, double w) {
  const auto m = static_cast<double>(e.squared.size());
  const auto square = [](double x) { return x * x; };
  double loss = 0.0;
  switch (c.mode) {
    case RobustMode::kNone:
      for (const double s : e.squared) loss += square(w) * s;
      return loss;
    case RobustMode::kPerObservation:
      for (const double s : e.squared) {
        loss += square(w) * s + c.lambda_w * square(1 - w) +
                c.lambda_m * square(std::min(m, 10.0)) * square(e.previous - w);
        if (!std::isnan(e.temporal)) loss += e.lambda_z * square(e.temporal - w);
      }
      return loss;
    case RobustMode::kPaper:
      for (const double s : e.squared) loss += square(w) * s;
      return loss + c.lambda_w * square(1 - w) + c.lambda_m * square(m * (e.previous - w));
    case RobustMode::kDynavins:
      for (const double s : e.squared) loss += huber(square(w) * s);
      return loss + huber(square(c.lambda_w * (1 - w))) +
             huber(square(c.lambda_m * e.rounds * (e.previous - w)));
  }
  return kNan;
}

/// The least value on [0, 1]: a scan, then golden section around its best.
double scanned_minimiser(const RobustWeightConfig& c, const RobustEvidence& e) {
  constexpr int kSteps = 1000;
  int best = 0;
  for (int i = 1; i <= kSteps; ++i) {
    if (by_definition(c, e, static_cast<double>(i) / kSteps) <
        by_definition(c, e, static_cast<double>(best) / kSteps)) {
      best = i;
    }
  }
  double low = static_cast<double>(std::max(0, best - 1)) / kSteps;
  double high = static_cast<double>(std::min(kSteps, best + 1)) / kSteps;
  const double golden = (std::sqrt(5.0) - 1.0) / 2.0;
  for (int i = 0; i < 60; ++i) {
    const double a = high - golden * (high - low), b = low + golden * (high - low);
    (by_definition(c, e, a) < by_definition(c, e, b) ? high : low) =
        by_definition(c, e, a) < by_definition(c, e, b) ? b : a;
  }
  return 0.5 * (low + high);
}

double weight(const RobustWeightConfig& c, const RobustEvidence& e) {
  const auto w = robust_weight(c, e);
  REQUIRE(w.has_value());
  return *w;
}

/// m observations with the same squared residual.
std::vector<double> observations(std::size_t m, double squared) {
  return std::vector<double>(m, squared);
}

RobustWeightConfig with(RobustMode mode, double lambda_w, double lambda_m) {
  return {mode, lambda_w, lambda_m};
}

}  // namespace

TEST_SUITE("backend.robust_weight") {
  TEST_CASE("the weight is where a scan and golden section find the least loss, in all modes") {
    std::mt19937_64 random(50);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    for (const RobustMode mode : kModes) {
      CAPTURE(static_cast<int>(mode));
      for (int trial = 0; trial < 2000; ++trial) {
        CAPTURE(trial);
        std::vector<double> squared(1 + random() % 11);
        const double size = std::pow(10.0, 6.0 * share(random) - 3.0);
        for (double& s : squared) s = trial % 7 == 0 ? 0.0 : size * share(random);
        const RobustWeightConfig c = with(mode, std::pow(10.0, 4.0 * share(random) - 2.0),
                                          trial % 5 == 0 ? 0.0 : 5.0 * share(random));
        // Weights before it outside [0, 1] push the minimum out of the interval too.
        const RobustEvidence e{
            .squared = squared,
            .previous = trial % 11 == 0 ? 6.0 * share(random) - 3.0 : share(random),
            .rounds = static_cast<std::uint32_t>(1 + random() % 40),
            .temporal = trial % 3 == 0 ? kNan : share(random),
            .lambda_z = std::pow(10.0, 4.0 * share(random) - 2.0)};
        const double w = weight(c, e), scanned = scanned_minimiser(c, e);
        CHECK(w >= 0.0);
        CHECK(w <= 1.0);
        const double least = by_definition(c, e, scanned);
        CHECK(by_definition(c, e, w) <= least + 1e-12 * (1.0 + least));
        // Rounding of the loss hides the minimum's place by the square root of that.
        CHECK(std::abs(w - scanned) < 1e-5);
        const double any = share(random);
        CHECK(robust_loss(c, e, any) == doctest::Approx(by_definition(c, e, any)).epsilon(1e-12));
      }
    }
  }

  TEST_CASE("without momentum the paper's loss at its minimum is that of Geman and McClure") {
    for (const double each : {0.0, 0.01, 0.3, 1.0, 7.0, 1e4}) {
      const auto squared = observations(6, each);
      const double S = 6 * each;
      for (const double lambda : {0.5, 2.0, 64.0}) {
        const RobustWeightConfig c = with(RobustMode::kPaper, lambda, 0.0);
        const RobustEvidence e{squared};
        const double w = weight(c, e);
        CHECK(w == doctest::Approx(lambda / (S + lambda)).epsilon(1e-12));
        CHECK(robust_loss(c, e, w) == doctest::Approx(lambda * S / (lambda + S)).epsilon(1e-12));
      }
    }
  }

  TEST_CASE("the errors of DynaVINS' settings on VIODE give the weights of its formulas") {
    // Nine observations, error e px a axis, f = 376 px, sigma 1.5 px at 460: S = 18 (e kappa /
    // f)^2.
    for (const double e_px : {0.2, 0.3, 0.5, 0.75, 1.0, 2.0, 5.0}) {
      CAPTURE(e_px);
      const double r = e_px * kPaperSigmasPerUnit / 376.0;
      const auto squared = observations(9, 2 * r * r);
      const double S = 18 * r * r;
      CHECK(weight(with(RobustMode::kPaper, 2.0, 0.0), {squared}) ==
            doctest::Approx(2 / (2 + S)).epsilon(1e-12));
      // Its regulariser 2 (1 - w) leaves Huber's parabola below w = 1/2, that is for S > 4.
      const double want = S <= 4 ? 4 / (4 + S) : 2 / S;
      CHECK(weight(with(RobustMode::kDynavins, 2.0, 0.0), {squared}) ==
            doctest::Approx(want).epsilon(1e-12));
    }
    // 0.5 px: 0.40 and 0.57.
    const double r = 0.5 * kPaperSigmasPerUnit / 376.0;
    const auto squared = observations(9, 2 * r * r);
    CHECK(std::abs(weight(with(RobustMode::kPaper, 2.0, 0.0), {squared}) - 0.40) < 0.005);
    CHECK(std::abs(weight(with(RobustMode::kDynavins, 2.0, 0.0), {squared}) - 0.57) < 0.005);
  }

  TEST_CASE(
      "a track of any length weighs the same at the same error, but not in the paper's mode") {
    const RobustWeightConfig ours{.lambda_m = 0.0};
    const auto three = observations(3, 2.0), eleven = observations(11, 2.0);
    CHECK(weight(ours, {three}) == doctest::Approx(weight(ours, {eleven})).epsilon(1e-12));
    const RobustWeightConfig paper = with(RobustMode::kPaper, 8.0, 0.0);
    CHECK(weight(paper, {three}) > 1.7 * weight(paper, {eleven}));
    // Its information grows with its length all the same: each observation counts w^2.
    CHECK(robust_loss(ours, {eleven}, 0.8) ==
          doctest::Approx(11.0 / 3.0 * robust_loss(ours, {three}, 0.8)).epsilon(1e-12));
  }

  TEST_CASE("without momentum a weight is one half where the mean square is lambda_w") {
    for (const double lambda_w : {2.0, 4.0, 8.0}) {
      const RobustWeightConfig c{.lambda_w = lambda_w, .lambda_m = 0.0};
      for (const double sigmas : {0.0, 1.0, 2.0, 10.0}) {
        CAPTURE(sigmas);
        const auto squared = observations(8, 2 * sigmas * sigmas);
        CHECK(weight(c, {squared}) ==
              doctest::Approx(lambda_w / (lambda_w + 2 * sigmas * sigmas)).epsilon(1e-12));
      }
    }
  }

  TEST_CASE("a track that starts to move is doubted within two rounds, however long it was known") {
    // From 0.8 with S = 40: M = 0.1 l_w n^2 with n = 10; the paper's figures 2 and 0.2 give
    // (2 + 20 * 0.8) / 62 = 0.290, then (2 + 20 * 0.290) / 62 = 0.126.
    const auto squared = observations(10, 4.0);
    const RobustWeightConfig c = with(RobustMode::kPaper, 2.0, 0.2);
    const double first = weight(c, {squared, 0.8});
    CHECK(first == doctest::Approx(18.0 / 62.0).epsilon(1e-12));
    CHECK(weight(c, {squared, first}) == doctest::Approx((2 + 20 * first) / 62).epsilon(1e-12));
    // More than ten observations do not make ours slower.
    const auto longer = observations(30, 4.0);
    const RobustWeightConfig ours;
    CHECK(weight(ours, {squared, 0.8}) ==
          doctest::Approx(weight(ours, {longer, 0.8})).epsilon(1e-12));
    // Nor does ours heed rounds, which make DynaVINS slow.
    CHECK(weight(ours, {squared, 0.8, 40}) == weight(ours, {squared, 0.8, 1}));
    const RobustWeightConfig dynavins = with(RobustMode::kDynavins, 2.0, 0.2);
    CHECK(weight(dynavins, {squared, 0.8, 40}) > weight(dynavins, {squared, 0.8, 1}));
  }

  TEST_CASE("what time tells pulls the weight by its share of the stiffness, and more when sure") {
    // 8 observations, mean square 2, momentum 0: (8 + 4 z) / (2 + 8 + 4).
    const auto squared = observations(8, 2.0);
    const RobustWeightConfig c{.lambda_w = 8.0, .lambda_m = 0.0};
    for (const double z : {0.0, 0.3, 1.0}) {
      const RobustEvidence e{.squared = squared, .temporal = z, .lambda_z = 4.0};
      CHECK(weight(c, e) == doctest::Approx((8 + 4 * z) / 14).epsilon(1e-12));
    }
    double last = weight(c, {squared});
    for (const double lambda_z : {0.01, 1.0, 10.0, 1000.0}) {
      const double w = weight(c, {.squared = squared, .temporal = 0.1, .lambda_z = lambda_z});
      CHECK(w < last);
      CHECK(w > 0.1);
      last = w;
    }
    CHECK(last == doctest::Approx(0.1).epsilon(0.1));
  }

  TEST_CASE("without evidence of time or trust in it the weight is that of geometry, to the bit") {
    const auto squared = observations(5, 3.0);
    for (const RobustMode mode : kModes) {
      const RobustWeightConfig c = with(mode, 2.0, 0.2);
      const double geometry = weight(c, {squared, 0.4, 3});
      for (const auto& [z, lambda_z] : {std::pair{kNan, 4.0}, std::pair{0.0, 0.0}}) {
        const RobustEvidence e{squared, 0.4, 3, z, lambda_z};
        CHECK(weight(c, e) == geometry);
        CHECK(robust_loss(c, e, 0.7) == robust_loss(c, {squared, 0.4, 3}, 0.7));
      }
      // Only ours has the term.
      const RobustEvidence e{squared, 0.4, 3, 0.0, 4.0};
      CHECK((weight(c, e) < geometry) == (mode == RobustMode::kPerObservation));
    }
  }

  TEST_CASE("without a mode every feature weighs 1 and its loss is the sum of squares") {
    const auto squared = observations(5, 300.0);
    const RobustWeightConfig c{.mode = RobustMode::kNone};
    const RobustEvidence e{squared, 0.2, 3, 0.0, 4.0};
    CHECK(weight(c, e) == 1.0);
    CHECK(robust_loss(c, e, 1.0) == doctest::Approx(1500.0).epsilon(1e-12));
    CHECK(robust_loss(c, e, 0.5) == doctest::Approx(by_definition(c, e, 0.5)).epsilon(1e-12));
    CHECK(observation_gain(c, 300.0, 1.0) == 1.0);
  }

  TEST_CASE("momentum without end keeps the weight, errors without end take it") {
    for (const RobustMode mode : {RobustMode::kPerObservation, RobustMode::kPaper}) {
      const auto squared = observations(8, 4.0);
      CHECK(weight(with(mode, 0.01, 1000.0), {squared, 0.3}) == doctest::Approx(0.3).epsilon(1e-3));
      const auto huge = observations(8, 1e12);
      CHECK(weight(with(mode, 8.0, 0.8), {huge, 1.0}) < 1e-8);
      CHECK(weight(with(mode, 8.0, 0.8), {huge, 1.0}) > 0.0);
    }
  }

  TEST_CASE("the gain of an observation is the slope of the loss by its squared residual") {
    std::mt19937_64 random(51);
    std::uniform_real_distribution<double> share(0.05, 1.0);
    for (const RobustMode mode : kModes) {
      const RobustWeightConfig c = with(mode, 2.0, 0.2);
      for (int trial = 0; trial < 200; ++trial) {
        std::vector<double> squared{share(random), 20 * share(random), 3.0};
        const double w = share(random);
        const double s = squared[1];
        if (std::abs(w * w * s - 1.0) < 1e-3) continue;  // at the corner of Huber's slope
        const double h = 1e-5 * s;
        squared[1] = s + h;
        const double above = by_definition(c, {squared, 0.5, 3}, w);
        squared[1] = s - h;
        const double below = by_definition(c, {squared, 0.5, 3}, w);
        CHECK(observation_gain(c, s, w) ==
              doctest::Approx((above - below) / (2 * h)).epsilon(1e-6));
      }
    }
  }

  TEST_CASE("NaN, infinity, negative squares, no observation and wrong settings are refused") {
    const auto squared = observations(4, 1.0);
    const double inf = std::numeric_limits<double>::infinity();
    for (const RobustMode mode : kAllModes) {
      const RobustWeightConfig c = with(mode, 2.0, 0.2);
      CHECK(robust_weight(c, {squared}).has_value());
      CHECK_FALSE(robust_weight(c, {}).has_value());
      for (const double bad : {kNan, inf, -1.0}) {
        auto wrong = squared;
        wrong[2] = bad;
        CHECK_FALSE(robust_weight(c, {wrong}).has_value());
      }
      CHECK_FALSE(robust_weight(c, {squared, kNan}).has_value());
      CHECK_FALSE(robust_weight(c, {squared, inf}).has_value());
      CHECK_FALSE(robust_weight(c, {squared, 1.0, 1, inf, 1.0}).has_value());
      for (const double bad : {kNan, inf, -1.0})
        CHECK_FALSE(robust_weight(c, {squared, 1.0, 1, 0.5, bad}).has_value());
      for (const double bad : {kNan, inf, -1.0, 1001.0}) {
        CHECK_FALSE(robust_weight(with(mode, bad, 0.2), {squared}).has_value());
        CHECK_FALSE(robust_weight(with(mode, 2.0, bad), {squared}).has_value());
      }
      CHECK_FALSE(robust_weight(with(mode, 0.0, 0.2), {squared}).has_value());
    }
  }
}

}  // namespace pled
