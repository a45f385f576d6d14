// Eqs. (6) and (7): the band of a line and its score, drawn by hand.
#include "pled_vins/reliability/line_band.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include "support/reliability/drawn_map.hpp"

namespace pled {
namespace {

using Eigen::Vector2d;
using support::DrawnMap;
using support::SlowCounts;

constexpr SlowCounts kOnceABin{1, 1, 1, 1, 1, 1, 1, 1};  // s = 1
constexpr SlowCounts kNewestFour{0, 0, 0, 0, 1, 1, 1, 1};
constexpr double kBeside1 = 0.726149037;  // exp(-1 / 2 sigma^2), sigma = 1.25
constexpr double kBeside2 = 0.278037300;  // exp(-4 / 2 sigma^2)

std::optional<LineBand> read(DrawnMap& drawn, const Vector2d& a, const Vector2d& b,
                             ScoreForm form) {
  return read_line_band(drawn.map(), DrawnMap::kLast, a, b, form);
}

/// Some pixels with some events.
void scribble(DrawnMap& drawn, std::mt19937_64& random, double share) {
  for (int y = 0; y < drawn.height_px(); ++y)
    for (int x = 0; x < drawn.width_px(); ++x) {
      if (static_cast<double>(random() % 1000) >= 1000 * share) continue;
      SlowCounts counts{};
      for (int& c : counts) c = static_cast<int>(random() % 5) / 2;
      drawn.draw(x, y, counts);
    }
}

}  // namespace

TEST_SUITE("reliability.line_band") {
  TEST_CASE("a band is the sum over all pixels of the grid that eqs. (6) and (7) tell") {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> x(-8.0, 68.0), y(-8.0, 53.0);
    int read_clean = 0;
    for (const double share : {0.15, 0.5, 1.0}) {
      DrawnMap drawn(60, 45);
      scribble(drawn, random, share);
      const AnchoredMap& map = drawn.map();
      for (int i = 0; i < 60; ++i) {
        const Vector2d a(x(random), y(random)), b(x(random), y(random));
        for (const bool paper : {true, false}) {
          CAPTURE(share);
          CAPTURE(i);
          CAPTURE(paper);
          const auto want = support::band_by_definition(drawn, a, b, paper);
          const auto got = read_line_band(map, DrawnMap::kLast, a, b,
                                          paper ? ScoreForm::kPaper : ScoreForm::kClean);
          REQUIRE(got.has_value() == (want.pixels >= (paper ? 1 : 5)));
          if (!got) continue;
          read_clean += paper ? 0 : 1;
          CHECK(got->pixels == static_cast<std::uint32_t>(want.pixels));
          CHECK(got->with_events == static_cast<std::uint32_t>(want.with_events));
          CHECK(got->s == doctest::Approx(want.s).epsilon(1e-9));
          CHECK(got->count_reliability == doctest::Approx(want.count_reliability).epsilon(1e-12));
          CHECK((got->gradient - want.gradient).norm() < 1e-9);
        }
      }
    }
    CHECK(read_clean > 100);
  }

  TEST_CASE(
      "one row of the band weighs as a Gaussian says, and only kPaper counts the empty ones") {
    for (int row = 18; row <= 22; ++row) {
      CAPTURE(row);
      DrawnMap drawn(40, 40);
      for (int x = 0; x < 40; ++x) drawn.draw(x, row, kOnceABin);
      const auto paper = read(drawn, {10, 20}, {19, 20}, ScoreForm::kPaper);
      const auto clean = read(drawn, {10, 20}, {19, 20}, ScoreForm::kClean);
      REQUIRE(paper);
      REQUIRE(clean);
      CHECK(paper->pixels == 50);
      CHECK(clean->pixels == 10);
      CHECK(paper->with_events == 10);
      const double weights[] = {kBeside2, kBeside1, 1.0, kBeside1, kBeside2};
      CHECK(paper->s ==
            doctest::Approx(weights[row - 18] / (1 + 2 * kBeside1 + 2 * kBeside2)).epsilon(1e-6));
      CHECK(clean->s == doctest::Approx(1.0));
      CHECK(clean->count_reliability == doctest::Approx(0.5));
      CHECK(temporal_reliability(*clean) == doctest::Approx(0.0));
    }
    DrawnMap beside(40, 40);
    for (int x = 0; x < 40; ++x) beside.draw(x, 23, kOnceABin);
    CHECK(read(beside, {10, 20}, {19, 20}, ScoreForm::kPaper)->s == doctest::Approx(0.0));
    CHECK(read(beside, {10, 20}, {19, 20}, ScoreForm::kPaper)->with_events == 0);
    CHECK_FALSE(read(beside, {10, 20}, {19, 20}, ScoreForm::kClean));
  }

  TEST_CASE("rows and columns are alike, and the ends may be swapped") {
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> at(3.0, 41.0);
    DrawnMap drawn(45, 45), turned(45, 45);
    scribble(drawn, random, 0.6);
    for (int y = 0; y < 45; ++y)
      for (int x = 0; x < 45; ++x) turned.draw(y, x, drawn.at(x, y));
    const AnchoredMap& map = drawn.map();
    const AnchoredMap& map_turned = turned.map();
    for (int i = 0; i < 50; ++i) {
      const Vector2d a(at(random), at(random)), b(at(random), at(random));
      for (const ScoreForm form : {ScoreForm::kPaper, ScoreForm::kClean}) {
        const auto one = read_line_band(map, DrawnMap::kLast, a, b, form);
        const auto swapped = read_line_band(map, DrawnMap::kLast, b, a, form);
        const auto other =
            read_line_band(map_turned, DrawnMap::kLast, a.reverse(), b.reverse(), form);
        REQUIRE(one);
        REQUIRE(swapped);
        REQUIRE(other);
        CHECK(one->s == swapped->s);
        CHECK(one->gradient == swapped->gradient);
        CHECK(one->pixels == swapped->pixels);
        CHECK(one->s == doctest::Approx(other->s).epsilon(1e-12));
        CHECK((one->gradient - other->gradient.reverse()).norm() < 1e-12);
        CHECK(one->pixels == other->pixels);
      }
    }
  }

  TEST_CASE("the gradient of q points where events are newest") {
    // An edge that came from the left: its front, at x = 24, fired in the newest bin.
    DrawnMap drawn(40, 40);
    for (int y = 5; y < 35; ++y)
      for (int x = 17; x <= 24; ++x) {
        SlowCounts counts{};
        counts[static_cast<std::size_t>(x - 17)] = 2;
        drawn.draw(x, y, counts);
      }
    const auto clean = read(drawn, {21, 10}, {21, 30}, ScoreForm::kClean);
    REQUIRE(clean);
    CHECK(clean->pixels == 5 * 21);
    // Columns 19 to 23: (w_{k+1} - w_{k-1}) / 2 (1 - w_min), w_k = exp(-2 (1 - (k + 0.5) / 8)).
    const auto w = [](double k) { return std::exp(-2.0 * (1.0 - (k + 0.5) / 8.0)); };
    double sum = 0.0;
    for (int k = 2; k <= 6; ++k) sum += (w(k + 1) - w(k - 1)) / 2.0 / (1.0 - std::exp(-2.0));
    CHECK(clean->gradient.x() == doctest::Approx(sum / 5.0));
    CHECK(std::abs(clean->gradient.y()) < 1e-12);
    // At the front a pixel without events stands beside the newest: kPaper sees a cliff there.
    const auto paper = read(drawn, {23, 10}, {23, 30}, ScoreForm::kPaper);
    REQUIRE(paper);
    CHECK(paper->gradient.x() < 0.0);
    CHECK(read(drawn, {23, 10}, {23, 30}, ScoreForm::kClean)->gradient.x() > 0.05);
  }

  TEST_CASE("what lies in the grid speaks for a band that leaves it") {
    DrawnMap drawn(40, 30);
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x) drawn.draw(x, y, x < 5 ? kNewestFour : kOnceABin);
    const auto out_left = read(drawn, {-50, 15}, {4, 15}, ScoreForm::kClean);
    REQUIRE(out_left);
    CHECK(out_left->pixels == 25);
    CHECK(out_left->s == doctest::Approx(support::score_by_definition(kNewestFour, 2.0, 0.0).s));
    const auto corner = read(drawn, {30, -1000}, {30, 3000}, ScoreForm::kPaper);
    REQUIRE(corner);
    CHECK(corner->pixels == 5 * 30);
    CHECK(corner->s == doctest::Approx(1.0));
    for (const ScoreForm form : {ScoreForm::kPaper, ScoreForm::kClean}) {
      CHECK_FALSE(read(drawn, {-3, 5}, {-3, 25}, form));
      CHECK_FALSE(read(drawn, {0, 33}, {39, 33}, form));
      CHECK(read(drawn, {0, 31}, {39, 31}, form)->pixels == 40);  // its outermost row
    }
  }

  TEST_CASE("no line has no band") {
    DrawnMap drawn(40, 30);
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x) drawn.draw(x, y, kOnceABin);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double inf = std::numeric_limits<double>::infinity();
    for (const ScoreForm form : {ScoreForm::kPaper, ScoreForm::kClean}) {
      CHECK_FALSE(read(drawn, {10, 10}, {10, 10}, form));
      CHECK_FALSE(read(drawn, {10, nan}, {20, 10}, form));
      CHECK_FALSE(read(drawn, {10, 10}, {inf, 10}, form));
      CHECK_FALSE(read(drawn, {10, 10}, {1e7, 10}, form));
      CHECK(read(drawn, {10, 10}, {9e5, 10}, form));
    }
    // One that is too short for a pixel but in kPaper may still have some beside it.
    CHECK(read(drawn, {10, 9.999}, {10, 10.001}, ScoreForm::kPaper)->pixels == 5);
    std::vector<BinCell> a(BinCounters::cells_needed(40, 30)), b = a;
    const AnchoredMap never_begun(ReliabilityConfig{}, 40, 30, {{a, b}});
    CHECK_FALSE(read_line_band(never_begun, 0, {5, 5}, {30, 5}, ScoreForm::kClean));
  }

  TEST_CASE("pixels with events must be at least five, unless all speak") {
    DrawnMap drawn(40, 30);
    for (int x = 10; x < 14; ++x) drawn.draw(x, 15, kOnceABin);
    CHECK_FALSE(read(drawn, {5, 15}, {30, 15}, ScoreForm::kClean));
    CHECK(read(drawn, {5, 15}, {30, 15}, ScoreForm::kPaper)->with_events == 4);
    drawn.draw(20, 16, kOnceABin);
    CHECK(read(drawn, {5, 15}, {30, 15}, ScoreForm::kClean)->pixels == 5);
  }

  TEST_CASE("of a long line samples are read, whose mean is that of all") {
    DrawnMap drawn(1300, 40);
    for (int x = 0; x < 1300; ++x)
      for (int y = 0; y < 40; ++y) drawn.draw(x, y, x % 5 < 2 ? kOnceABin : SlowCounts{3});
    const AnchoredMap& map = drawn.map();
    const auto pixels = [&](const Vector2d& a, const Vector2d& b) {
      return read_line_band(map, DrawnMap::kLast, a, b, ScoreForm::kClean)->pixels;
    };
    CHECK(pixels({10, 20}, {169, 20}) == 5 * 160);
    const std::uint32_t longest = pixels({0, 5}, {1299, 35});
    CHECK(longest <= 8 * kMaxBandColumns);
    CHECK(longest >= 4 * kMaxBandColumns / 2);
    const auto sampled =
        read_line_band(map, DrawnMap::kLast, {0, 20}, {1299, 20}, ScoreForm::kClean);
    REQUIRE(sampled);
    CHECK(sampled->s == doctest::Approx(0.4).epsilon(0.05));  // 2 of 5 columns have s = 1, 3 have 0
  }
}

}  // namespace pled
