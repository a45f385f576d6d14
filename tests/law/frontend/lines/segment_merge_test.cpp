#include "pled_vins/frontend/lines/segment_merge.hpp"

#include <cmath>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/frontend/lines/edge_fit.hpp"
#include "support/frontend/drawn_edges.hpp"

namespace pled {
namespace {

Segment segment_of(double x0, double y0, double x1, double y1, float steepness = 40.0F) {
  Segment s;
  s.set({x0, y0}, {x1, y1});
  s.steepness = steepness;
  return s;
}

Segments list_of(std::initializer_list<Segment> items) {
  Segments out;
  for (const Segment& s : items) REQUIRE(out.push_back(s));
  return out;
}

}  // namespace

TEST_SUITE("frontend.segment_merge") {
  TEST_CASE("how one segment lies beside another is told in the first one's frame") {
    const Segment a = segment_of(10, 20, 60, 20);  // along x: its normal points up, to -y
    const BesideSegment at = beside(a, segment_of(30, 17, 90, 14));
    CHECK(at.common_px == doctest::Approx(30.0));
    CHECK(at.ends_e_px[0] == doctest::Approx(3.0));
    CHECK(at.ends_e_px[1] == doctest::Approx(6.0));
    CHECK(at.farthest_px == doctest::Approx(4.5));  // at x = 60
    CHECK(at.offset_px == doctest::Approx(3.75));   // at x = 45
    CHECK(at.angle_rad() == doctest::Approx(-std::atan(0.05)));
    CHECK(beside(a, segment_of(75, 20, 90, 20)).common_px == doctest::Approx(-15.0));
    CHECK(std::abs(beside(a, segment_of(60, 20, 10, 20)).angle_rad()) ==
          doctest::Approx(std::numbers::pi));
  }

  TEST_CASE("two that surely do not run alike are told from their angle, and no others") {
    std::mt19937_64 random(11);
    int told = 0;
    int alike = 0;
    for (int run = 0; run < 20'000; ++run) {
      CAPTURE(run);
      const auto place = [&] { return 100.0 * support::uniform(random); };
      Segment a = segment_of(place(), place(), place(), place());
      Segment b = segment_of(place(), place(), place(), place());
      // Every second one within 20 degrees of the first.
      const double turn = 0.7 * (support::uniform(random) - 0.5);
      const Eigen::Vector2d d = a.direction();
      if (run % 2 == 0)
        b.set(b.start(),
              b.start() + 30.0 * Eigen::Vector2d(d.x() * std::cos(turn) - d.y() * std::sin(turn),
                                                 d.x() * std::sin(turn) + d.y() * std::cos(turn)));
      const double limit_rad = 0.5 * support::uniform(random);
      const double angle_rad = std::abs(beside(a, b).angle_rad());
      if (angle_rad <= limit_rad) {
        CHECK(may_run_alike(a, b, limit_rad));
        ++alike;
      }
      if (angle_rad > limit_rad + 0.2 * limit_rad * limit_rad * limit_rad + 1e-9) {
        CHECK_FALSE(may_run_alike(a, b, limit_rad));
        ++told;
      }
    }
    CHECK(told > 10'000);
    CHECK(alike > 4'000);
    // What has no direction may run any way.
    CHECK(may_run_alike(segment_of(1, 2, 1, 2), segment_of(0, 0, 0, 9), 0.05));
  }

  TEST_CASE("random cuts of one line are joined to it again") {
    std::mt19937_64 random(1);
    for (int run = 0; run < 50; ++run) {
      CAPTURE(run);
      const double turn = 2 * std::numbers::pi * support::uniform(random);
      const Eigen::Vector2d d(std::cos(turn), std::sin(turn));
      const Eigen::Vector2d from(120 - 80 * d.x(), 90 - 80 * d.y());
      Segments pieces;
      double s = 0.0;
      while (s < 140.0) {
        const double next = s + 12.0 + 20.0 * support::uniform(random);
        Segment piece;
        piece.set(from + s * d, from + next * d);
        REQUIRE(pieces.push_back(piece));
        s = next + 9.0 * support::uniform(random);
        if (s >= 140.0) s = next;
        if (next >= 140.0) break;
      }
      const double end = (pieces[pieces.size() - 1].end() - from).norm();
      merge_collinear(pieces);
      REQUIRE(pieces.size() == 1);
      CHECK((pieces[0].start() - from).norm() < 1e-9);
      CHECK((pieces[0].end() - (from + end * d)).norm() < 1e-9);
    }
  }

  TEST_CASE("a joint is the total least squares line of both masses") {
    const Segment a = segment_of(0, 0, 40, 0);
    const Segment b = segment_of(45, 1.5, 65, 1.5);
    Segments pieces = list_of({b, a});
    merge_collinear(pieces);
    REQUIRE(pieces.size() == 1);
    // The same by ten thousand points spread over both.
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    Eigen::Matrix2d M = Eigen::Matrix2d::Zero();
    const auto each = [&](const auto& use) {
      for (int i = 0; i < 10000; ++i) {
        const double s = (i + 0.5) / 10000 * 60.0;
        use(s < 40 ? Eigen::Vector2d(s, 0) : Eigen::Vector2d(s + 5, 1.5));
      }
    };
    each([&](const Eigen::Vector2d& p) { mean += p / 10000; });
    each([&](const Eigen::Vector2d& p) { M += (p - mean) * (p - mean).transpose(); });
    const double angle = 0.5 * std::atan2(2 * M(0, 1), M(0, 0) - M(1, 1));
    const Eigen::Vector2d d(std::cos(angle), std::sin(angle));
    CHECK(support::off_line_px(pieces[0], mean, mean + d) < 1e-3);
    CHECK(pieces[0].direction().dot(d) > 0.999999);
  }

  TEST_CASE("what turns, lies beside, is far, runs against or shows other events stays apart") {
    const Segment line = segment_of(0, 0, 60, 0);
    Segment off = segment_of(65, 0, 95, 0);
    off.active_is_bright = false;
    for (const Segment& other : {segment_of(65, 0, 95, 2.0), segment_of(65, 2.5, 95, 2.5),
                                 segment_of(71, 0, 95, 0), segment_of(95, 0, 65, 0), off}) {
      Segments pieces = list_of({line, other});
      merge_collinear(pieces);
      CHECK(pieces.size() == 2);
    }
  }

  TEST_CASE("of two sides that face each other the steeper stays, others all") {
    // Along +y the bright side is to the right (+x), along -y to the left.
    const Segment front = segment_of(50, 100, 50, 0, 60.0F);       // bright to the left
    const Segment trail = segment_of(44, 10, 44, 90, 20.0F);       // bright to the right
    const Segment next_front = segment_of(38, 100, 38, 0, 50.0F);  // as the first
    const Segment far_trail = segment_of(20, 0, 20, 100, 20.0F);
    Segments all = list_of({front, trail, next_front, far_trail});
    keep_fronts(8.0, all);
    REQUIRE(all.size() == 3);
    CHECK(all[0].start_px == front.start_px);
    CHECK(all[1].start_px == next_front.start_px);
    CHECK(all[2].start_px == far_trail.start_px);
    // Events between them must be of one polarity, and between them.
    Segment dark = trail;
    dark.active_is_bright = false;
    Segments other = list_of({front, dark});
    keep_fronts(8.0, other);
    CHECK(other.size() == 2);
    Segments outside = list_of({front, segment_of(56, 10, 56, 90, 20.0F)});
    keep_fronts(8.0, outside);
    CHECK(outside.size() == 2);
    // As steep and apart by more than a thin trail: two edges.
    Segments alike = list_of({front, segment_of(44, 10, 44, 90, 58.0F)});
    keep_fronts(8.0, alike);
    CHECK(alike.size() == 2);
    Segments thin = list_of({front, segment_of(48, 10, 48, 90, 58.0F)});
    keep_fronts(8.0, thin);
    CHECK(thin.size() == 1);
  }

  TEST_CASE("a full list of pieces is merged without loss of what does not belong together") {
    Segments pieces;
    for (int i = 0; i < static_cast<int>(limits::kMaxSegments); ++i)
      REQUIRE(pieces.push_back(segment_of(0, 5.0 * i, 60, 5.0 * i)));
    merge_collinear(pieces);
    CHECK(pieces.size() == limits::kMaxSegments);
    for (int i = 0; i < 128; ++i) pieces[static_cast<std::size_t>(i)] = segment_of(i, 0, i + 30, 0);
    while (pieces.size() > 128) pieces.pop_back();
    merge_collinear(pieces);
    REQUIRE(pieces.size() == 1);
    CHECK(pieces[0].length_px() == doctest::Approx(157.0));
  }

  TEST_CASE("a fitted edge is where it was drawn, and bows as it was drawn") {
    const FlatPixels flat(support::plain_camera(240, 180));
    for (const double bow : {0.0, 0.5, 1.5}) {
      CAPTURE(bow);
      const auto image = support::draw(240, 180, [&](double x, double y) {
        const double u = (x - 120.0) / 50.0;
        return y > 80.3 + 0.2 * (x - 120.0) + bow * (1 - u * u) ? 180.0 : 60.0;
      });
      std::vector<GradientPixel> pixels(240 * 180);
      const ImageView<GradientPixel> gradient{pixels.data(), 240, 180, 240};
      sobel(image.view(), gradient);
      Segment rough = segment_of(170, 91.0, 70, 70.0);
      REQUIRE(look_across(image.view(), LinePicture::kGrey, flat, rough));
      const std::optional<FittedEdge> edge = fit_edge(gradient, flat, rough);
      REQUIRE(edge.has_value());
      // y is 1 / sqrt(1.04) as far across as down. Places between pixels err by up to 0.1 px.
      CHECK(std::abs(edge->bow_px - bow / std::sqrt(1.04)) < 0.15);
      const double mean_y = 80.3 + bow * 2.0 / 3.0;  // of a parabola
      CHECK(support::off_line_px(edge->segment, {120, mean_y}, {220, mean_y + 20}) < 0.1);
    }
  }

  TEST_CASE("beside no edge nothing is fitted, and nothing looks like one") {
    const FlatPixels flat(support::plain_camera(240, 180));
    const auto image = support::draw(
        240, 180, [](double x, double y) { return y > 80.0 && x < 110.0 ? 180.0 : 60.0; });
    std::vector<GradientPixel> pixels(240 * 180);
    const ImageView<GradientPixel> gradient{pixels.data(), 240, 180, 240};
    sobel(image.view(), gradient);
    CHECK_FALSE(fit_edge(gradient, flat, segment_of(40, 40, 140, 40)).has_value());
    CHECK_FALSE(fit_edge(gradient, flat, segment_of(200, 80, 80, 80)).has_value());  // a quarter
    CHECK(fit_edge(gradient, flat, segment_of(130, 80, 30, 80)).has_value());
    Segment nothing = segment_of(40, 40, 140, 40);
    CHECK_FALSE(look_across(image.view(), LinePicture::kGrey, flat, nothing));
    Segment rim = segment_of(0, 0, 239, 0);
    CHECK_FALSE(look_across(image.view(), LinePicture::kGrey, flat, rim));
  }
}

}  // namespace pled
