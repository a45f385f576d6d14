#include "pled_vins/evaluation/weights.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>

namespace pled {
namespace {

/// Every pair of one at rest and one that moves: 1 for the right order, 1/2 for a tie.
double auc_by_pairs(const std::vector<LabelledWeight>& rows) {
  double won = 0.0;
  double pairs = 0.0;
  for (const LabelledWeight& a : rows) {
    if (a.is_moving) continue;
    for (const LabelledWeight& b : rows) {
      if (!b.is_moving) continue;
      won += a.w > b.w ? 1.0 : (a.w == b.w ? 0.5 : 0.0);
      pairs += 1.0;
    }
  }
  return won / pairs;
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_SUITE("evaluation.weights") {
  TEST_CASE("the area under the curve is the share of pairs in the right order, ties too") {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
      std::mt19937_64 random(seed);
      std::uniform_real_distribution<double> unit(0.0, 1.0);
      std::vector<LabelledWeight> rows;
      const double steps = seed % 2 == 0 ? 5.0 : 1e6;  // every second time nearly all are tied
      for (int i = 0; i < 301; ++i) {
        const bool moving = unit(random) < 0.1 * static_cast<double>(seed);
        const double w = std::min(1.0, unit(random) * (moving ? 0.8 : 1.1));
        rows.push_back({std::round(w * steps) / steps, moving});
      }
      const WeightQuality q = judge_weights(rows);
      CAPTURE(seed);
      REQUIRE(q.auc);
      CHECK(*q.auc == doctest::Approx(auc_by_pairs(rows)).epsilon(1e-12));
      CHECK(q.n_static + q.n_dynamic == rows.size());
    }
  }

  TEST_CASE("perfect order is 1, the reverse 0") {
    const std::vector<LabelledWeight> good{{0.9, false}, {0.1, true}, {0.8, false}, {0.2, true}};
    CHECK(*judge_weights(good).auc == 1.0);
    std::vector<LabelledWeight> bad = good;
    for (LabelledWeight& row : bad) row.is_moving = !row.is_moving;
    CHECK(*judge_weights(bad).auc == 0.0);
  }

  TEST_CASE("a constant tells nothing, however many move") {
    for (const double w : {0.0, 0.3, 1.0}) {
      std::vector<LabelledWeight> rows(90, {w, false});
      rows.insert(rows.end(), 10, {w, true});
      const WeightQuality q = judge_weights(rows);
      CAPTURE(w);
      CHECK(*q.auc == doctest::Approx(0.5));
      CHECK(*q.mae_balanced == doctest::Approx(0.5));
      CHECK(*q.mae == doctest::Approx(0.9 * (1 - w) + 0.1 * w));
      CHECK(*q.mae_of_one() == doctest::Approx(0.1));
      CHECK(q.w_ratio.has_value() == (w > 0.0));
    }
  }

  TEST_CASE("errors and the ratio are those of their definitions") {
    const std::vector<LabelledWeight> rows{{0.9, false}, {0.7, false}, {0.8, false}, {0.2, true}};
    const WeightQuality q = judge_weights(rows);
    CHECK(*q.mae == doctest::Approx((0.1 + 0.3 + 0.2 + 0.2) / 4));
    CHECK(*q.mae_balanced == doctest::Approx(0.5 * (0.2 + 0.2)));
    CHECK(*q.w_ratio == doctest::Approx(0.8 / 0.2));
    CHECK(*q.mean_static == doctest::Approx(0.8));
  }

  TEST_CASE("the ratio is absent when what moves has no weight at all") {
    const std::vector<LabelledWeight> rows{{0.9, false}, {0.0, true}};
    const WeightQuality q = judge_weights(rows);
    CHECK_FALSE(q.w_ratio);
    CHECK(*q.auc == 1.0);
  }

  TEST_CASE("rows without evidence are left out") {
    const std::vector<LabelledWeight> known{{0.9, false}, {0.6, true}, {0.5, false}};
    std::vector<LabelledWeight> rows{{kNaN, true}, {0.9, false}, {kNaN, false},
                                     {0.6, true},  {kNaN, true}, {0.5, false}};
    const WeightQuality a = judge_weights(known);
    const WeightQuality b = judge_weights(rows);
    CHECK(b.n_static == 2);
    CHECK(b.n_dynamic == 1);
    CHECK(*a.auc == 0.5);
    CHECK(b.auc == a.auc);
    CHECK(b.mae == a.mae);
    CHECK(b.mae_balanced == a.mae_balanced);
    CHECK(b.w_ratio == a.w_ratio);
  }

  TEST_CASE("without one of the classes only the plain error is told, without rows nothing") {
    for (const bool moving : {false, true}) {
      const std::vector<LabelledWeight> rows{{0.25, moving}, {0.75, moving}, {kNaN, !moving}};
      const WeightQuality q = judge_weights(rows);
      CHECK_FALSE(q.auc);
      CHECK_FALSE(q.mae_balanced);
      CHECK_FALSE(q.w_ratio);
      CHECK(*q.mae == doctest::Approx(0.5));
      CHECK(*q.mae_of_one() == (moving ? 1.0 : 0.0));
      CHECK(q.mean_static.has_value() == !moving);
      CHECK((moving ? q.n_dynamic : q.n_static) == 2);
    }
    const WeightQuality none = judge_weights({});
    CHECK_FALSE(none.mae);
    CHECK_FALSE(none.mae_of_one());
    CHECK_FALSE(none.mean_static);
    CHECK_FALSE(none.auc);
  }
}

}  // namespace pled
