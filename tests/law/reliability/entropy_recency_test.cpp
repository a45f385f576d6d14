#include "pled_vins/reliability/entropy_recency.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>

#include <doctest/doctest.h>

#include "pled_vins/reliability/event_count.hpp"
#include "support/reliability/score_by_definition.hpp"

namespace pled {
namespace {

constexpr double kAlpha = 2.0;

support::SlowCounts random_counts(std::mt19937_64& random) {
  support::SlowCounts c{};
  const std::uint64_t most = std::uint64_t{1} << (random() % 9);  // up to 256: few to many events
  const std::uint64_t filled = 1 + random() % 8;
  for (int& count : c) {
    if (random() % 8 < filled) count = static_cast<int>(random() % most);
  }
  return c;
}

}  // namespace

TEST_SUITE("reliability.entropy_recency") {
  TEST_CASE("the scores of simple patterns are those of the formula") {
    struct Row {
      const char* pattern;
      support::SlowCounts c;
      double h, q, s;  // the known values, three digits
    };
    const Row rows[] = {
        {"newest two", {0, 0, 0, 0, 0, 0, 1, 1}, .333, .751, .602},
        {"newest three", {0, 0, 0, 0, 0, 1, 1, 1}, .528, .655, .680},
        {"newest four", {0, 0, 0, 0, 1, 1, 1, 1}, .667, .573, .728},
        {"1, 3, 6 at the end", {0, 0, 0, 0, 0, 1, 3, 6}, .432, .756, .702},
        {"oldest and newest", {1, 0, 0, 0, 0, 0, 0, 1}, .333, .443, .284},
        {"even bins", {1, 0, 1, 0, 1, 0, 1, 0}, .667, .280, .438},
        {"odd bins", {0, 1, 0, 1, 0, 1, 0, 1}, .667, .404, .576},
        {"oldest four", {1, 1, 1, 1, 0, 0, 0, 0}, .667, .112, .201},
        {"ramp", {1, 2, 3, 4, 5, 6, 7, 8}, .931, .479, .926},
        {"reverse ramp", {8, 7, 6, 5, 4, 3, 2, 1}, .931, .206, .779},
        {"two a bin, newest empty", {2, 2, 2, 2, 2, 2, 2, 0}, .936, .268, .842},
        {"one a bin", {1, 1, 1, 1, 1, 1, 1, 1}, 1.0, .342, 1.0},
        {"oldest only", {1, 0, 0, 0, 0, 0, 0, 0}, 0.0, .0208, 0.0},
        {"newest only", {0, 0, 0, 0, 0, 0, 0, 1}, 0.0, .8641, 0.0},
    };
    const ScoreTables tables(kAlpha);
    for (const Row& row : rows) {
      CAPTURE(row.pattern);
      const PixelScore want = support::score_by_definition(row.c, kAlpha, 0.0);
      for (const ScoreForm form : {ScoreForm::kClean, ScoreForm::kPaper}) {
        const PixelScore got = tables.score(support::narrow(row.c), form);
        CHECK(std::abs(got.h - want.h) < 1e-6);
        CHECK(std::abs(got.q - want.q) < 1e-6);
        CHECK(std::abs(got.s - want.s) < 1e-6);
        CHECK(std::abs(got.h - row.h) < 6e-4);
        CHECK(std::abs(got.q - row.q) < 6e-4);
        CHECK(std::abs(got.s - row.s) < 6e-4);
      }
    }
  }

  TEST_CASE("a pixel without events scores 0, and as the paper prints it q falls below 0") {
    const ScoreTables tables(kAlpha);
    const PixelScore clean = tables.score({});
    CHECK(clean.n == 0);
    CHECK(clean.h == 0.0);
    CHECK(clean.q == 0.0);
    CHECK(clean.s == 0.0);
    const PixelScore paper = tables.score({}, ScoreForm::kPaper);
    const double w_min = std::exp(-kAlpha);
    CHECK(paper.h == 0.0);
    CHECK(std::abs(paper.q + w_min / (1.0 - w_min)) < 1e-8);  // -0.1565
    CHECK(paper.s == 0.0);
    CHECK(temporal_reliability(paper) == 1.0);
  }

  TEST_CASE("tables and logarithms give the same score for any counts and alpha") {
    std::mt19937_64 random(1);
    for (const double alpha : {0.1, 2.0, 5.0}) {
      const ScoreTables tables(alpha);
      double worst_clean = 0.0;
      double worst_paper = 0.0;
      for (int i = 0; i < 20'000; ++i) {
        const support::SlowCounts c = random_counts(random);
        if (std::accumulate(c.begin(), c.end(), 0) == 0) continue;
        const BinCounts counts = support::narrow(c);
        const auto difference = [](const PixelScore& a, const PixelScore& b) {
          return std::max({std::abs(a.h - b.h), std::abs(a.q - b.q), std::abs(a.s - b.s)});
        };
        const PixelScore clean = tables.score(counts);
        worst_clean =
            std::max(worst_clean, difference(clean, support::score_by_definition(c, alpha, 0.0)));
        worst_paper = std::max(worst_paper,
                               difference(tables.score(counts, ScoreForm::kPaper),
                                          support::score_by_definition(c, alpha, kPaperEpsilon)));
        CHECK(clean.n == static_cast<std::uint32_t>(std::accumulate(c.begin(), c.end(), 0)));
      }
      CAPTURE(alpha);
      CHECK(worst_clean < 1e-9);
      CHECK(worst_paper < 1e-12);
    }
  }

  TEST_CASE("the score exceeds one half exactly when entropy and recency together exceed one") {
    std::mt19937_64 random(2);
    const ScoreTables tables(kAlpha);
    int above = 0;
    int below = 0;
    for (int i = 0; i < 20'000; ++i) {
      const PixelScore score = tables.score(support::narrow(random_counts(random)));
      if (std::abs(score.h + score.q - 1.0) < 1e-9) continue;
      CHECK((score.s > 0.5) == (score.h + score.q > 1.0));
      ++(score.s > 0.5 ? above : below);
      CHECK(score.s >= 0.0);
      CHECK(score.s <= 1.0);
      CHECK(temporal_reliability(score) == 1.0 - score.s);
    }
    CHECK(above > 1000);
    CHECK(below > 1000);
  }

  TEST_CASE("epsilon moves no score of a pixel with events by more than a millionth") {
    std::mt19937_64 random(3);
    const ScoreTables tables(kAlpha);
    double worst = 0.0;
    for (int i = 0; i < 20'000; ++i) {
      const BinCounts counts = support::narrow(random_counts(random));
      const PixelScore clean = tables.score(counts);
      if (clean.n == 0) continue;
      worst = std::max(worst, std::abs(clean.s - tables.score(counts, ScoreForm::kPaper).s));
    }
    CHECK(worst < 1e-6);
  }

  TEST_CASE("bins weigh more the newer they are, between w_min and 1") {
    const ScoreTables tables(kAlpha);
    for (std::size_t k = 0; k < limits::kTimeBins; ++k) {
      CHECK(tables.weight(k) > std::exp(-kAlpha));
      CHECK(tables.weight(k) < 1.0);
      if (k > 0)  // each by the same factor, e^(alpha / B)
        CHECK(tables.weight(k) / tables.weight(k - 1) == doctest::Approx(std::exp(kAlpha / 8)));
    }
  }

  TEST_CASE("the bare event count falls from 1 with every event") {
    CHECK(event_count_reliability(0) == 1.0);
    CHECK(event_count_reliability(8, 8.0) == 0.5);
    for (std::uint32_t n = 0; n < 2040; ++n) {
      CHECK(event_count_reliability(n + 1) < event_count_reliability(n));
      CHECK(event_count_reliability(n + 1) > 0.0);
    }
  }
}
}  // namespace pled
