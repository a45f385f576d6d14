#include <cmath>
#include <ctime>
#include <numbers>
#include <optional>
#include <random>

#include <doctest/doctest.h>

#include "support/frontend/drawn_edges.hpp"

namespace pled {
namespace {

using support::draw;
using support::GreyImage;
using support::OwnedDetector;
using support::plain_camera;
using support::Rectangle;

constexpr int kWidth = 240;
constexpr int kHeight = 180;

GreyImage draw_rectangle(const Rectangle& r, double inside = 200.0, double outside = 60.0) {
  return draw(kWidth, kHeight,
              [&](double x, double y) { return r.holds(x, y) ? inside : outside; });
}

/// Grey of a time surface in which an edge that leans has just come to `front_px` at the top;
/// behind it, to the left, events fade.
GreyImage draw_swept_edge(double front_px, double lean, double decay_px, double neutral,
                          double peak) {
  return draw(kWidth, kHeight, [&](double x, double y) {
    const double behind = front_px + lean * y - x;
    return behind < 0.0 || y < 20.0 || y > 160.0 ? neutral
                                                 : neutral + peak * std::exp(-behind / decay_px);
  });
}

void check_bounds(const DetectedLines& lines, std::size_t most) {
  CHECK(lines.size() <= most);
  for (const DetectedLine& line : lines)
    for (const auto& end : line.raw_px) {
      CHECK((end[0] >= 0.0 && end[0] <= kWidth - 1));
      CHECK((end[1] >= 0.0 && end[1] <= kHeight - 1));
    }
}

}  // namespace

TEST_SUITE("frontend.line_detector") {
  TEST_CASE("the four edges of a bright rectangle are found where they were drawn") {
    OwnedDetector detector(plain_camera(kWidth, kHeight));
    for (const double turn_deg : {0.0, 7.0, 20.0, 45.0, 61.0, 88.0}) {
      CAPTURE(turn_deg);
      const Rectangle r({121.3, 88.7}, 52.0, 37.0, turn_deg * std::numbers::pi / 180.0);
      const DetectedLines lines = detector.detect(draw_rectangle(r));
      REQUIRE(lines.size() == 4);
      for (std::size_t k = 0; k < 4; ++k) {
        // With the bright side on the left of a screen the corners come against the clock.
        const Eigen::Vector2d from = r.corner((k + 1) % 4);
        const Eigen::Vector2d to = r.corner(k);
        double best_px = 1e9;
        const DetectedLine* best = nullptr;
        for (const DetectedLine& line : lines) {
          const double off = support::off_ends_px(line.segment, from, to);
          if (off < best_px) best = &line;
          best_px = std::min(best_px, off);
        }
        REQUIRE(best != nullptr);
        CHECK(best_px < 3.0);  // the blur of LSD rounds corners off
        CHECK(support::off_line_px(best->segment, from, to) < 0.15);
        CHECK(best->segment.active_is_bright);
        CHECK(best->segment.steepness > 30.0F);
      }
    }
  }

  TEST_CASE("the edges of a dark rectangle run the other way round") {
    OwnedDetector detector(plain_camera(kWidth, kHeight));
    const Rectangle r({121.3, 88.7}, 52.0, 37.0, 0.3);
    const DetectedLines lines = detector.detect(draw_rectangle(r, 40.0, 180.0));
    REQUIRE(lines.size() == 4);
    for (const DetectedLine& line : lines) {
      const Eigen::Vector2d outwards =
          0.5 * (line.segment.start() + line.segment.end()) - r.middle();
      CHECK(line.segment.normal().dot(outwards) > 0.0);
    }
  }

  TEST_CASE("an edge broken by a narrow notch is one line, by a wide one two") {
    OwnedDetector detector(plain_camera(kWidth, kHeight));
    for (const double notch : {5.0, 30.0}) {
      CAPTURE(notch);
      const GreyImage image = draw(kWidth, kHeight, [&](double x, double y) {
        const double edge = 80.0 + 0.1 * (x - 120.0);
        return y > edge && std::abs(x - 120.0) > 0.5 * notch && x > 30 && x < 210 ? 190.0 : 70.0;
      });
      int along_edge = 0;
      for (const DetectedLine& line : detector.detect(image))
        if (support::off_line_px(line.segment, {120, 80}, {220, 90}) < 1.0) {
          ++along_edge;
          CHECK(line.segment.length_px() > (notch < 10.0 ? 170.0 : 65.0));
        }
      CHECK(along_edge == (notch < 10.0 ? 1 : 2));
    }
  }

  TEST_CASE("of an edge on a time surface the side where events come is kept") {
    struct Kind {
      LinePicture picture;
      double neutral, peak;
    };
    for (const Kind& kind :
         {Kind{LinePicture::kSurface, 0.0, 255.0}, Kind{LinePicture::kSignedSurface, 128.0, 127.0},
          Kind{LinePicture::kSignedSurface, 128.0, -128.0}}) {
      for (const double decay_px : {2.0, 4.0}) {
        CAPTURE(kind.peak);
        CAPTURE(decay_px);
        const GreyImage image = draw_swept_edge(120.0, 0.2, decay_px, kind.neutral, kind.peak);
        OwnedDetector detector(plain_camera(kWidth, kHeight), kind.picture);
        const DetectedLines lines = detector.detect(image);
        REQUIRE(lines.size() == 1);
        CHECK(support::off_line_px(lines[0].segment, {120, 0}, {156, 180}) < 0.7);
        CHECK(lines[0].segment.length_px() > 125.0);
        CHECK(lines[0].segment.active_is_bright == (kind.peak > 0.0));
        // The sides of a frame's stripe are both edges.
        OwnedDetector as_frame(plain_camera(kWidth, kHeight), LinePicture::kGrey);
        CHECK(as_frame.detect(image).size() >= 2);
      }
    }
  }

  TEST_CASE("edges that one motion drew beside each other on a time surface all stay") {
    // A pole that moves to the right: its right edge ON, its left one OFF, both with trails.
    const GreyImage image = draw(kWidth, kHeight, [](double x, double y) {
      if (y < 20 || y > 160) return 128.0;
      const double right = 126.0 - x;
      const double left = 117.0 - x;
      if (left >= 0.0) return 128.0 - 128.0 * std::exp(-left / 2.0);
      return right >= 0.0 ? 128.0 + 127.0 * std::exp(-right / 2.0) : 128.0;
    });
    OwnedDetector detector(plain_camera(kWidth, kHeight), LinePicture::kSignedSurface);
    const DetectedLines lines = detector.detect(image);
    REQUIRE(lines.size() == 2);
    CHECK(lines[0].segment.active_is_bright != lines[1].segment.active_is_bright);
  }

  TEST_CASE("straight edges seen through a lens are whole and straight in flat pixels") {
    const Camera camera = support::davis240_camera(true);
    const FlatPixels flat(camera);
    const Rectangle r({125.0, 96.0}, 105.0, 76.0, 0.05);
    const GreyImage image = draw(kWidth, kHeight, [&](double x, double y) {
      const std::optional<Eigen::Vector2d> at = flat.from_raw({x, y});
      return at && r.holds(at->x(), at->y()) ? 190.0 : 60.0;
    });
    OwnedDetector detector(camera);
    const DetectedLines lines = detector.detect(image);
    REQUIRE(lines.size() >= 2);
    int on_edges = 0;
    for (const DetectedLine& line : lines)
      for (std::size_t k = 0; k < 4; ++k)
        if (support::off_line_px(line.segment, r.corner((k + 1) % 4), r.corner(k)) < 0.6)
          ++on_edges;
    CHECK(on_edges == static_cast<int>(lines.size()));
    CHECK(lines[0].segment.length_px() > 150.0);  // raw, it bows by more than 4 px
  }

  TEST_CASE("lines shorter than their share of the picture are left out") {
    LineConfig config;
    config.min_length_share = 0.3;
    OwnedDetector detector(plain_camera(kWidth, kHeight), LinePicture::kGrey, config);
    CHECK(detector.detector().min_length_px() == doctest::Approx(54.0));
    const DetectedLines lines =
        detector.detect(draw_rectangle(Rectangle({120, 90}, 45.0, 22.0, 0.2)));
    CHECK(lines.size() == 2);
    for (const DetectedLine& line : lines) CHECK(line.segment.length_px() >= 54.0);
  }

  TEST_CASE("stripes by the hundred fill the list and no more") {
    OwnedDetector detector(plain_camera(kWidth, kHeight));
    const GreyImage image = draw(kWidth, kHeight, [](double x, double y) {
      return std::fmod(x + 0.1 * y + 100.0, 5.0) < 2.5 ? 220.0 : 30.0;
    });
    const DetectedLines lines = detector.detect(image);
    CHECK(lines.size() >= 40);
    check_bounds(lines, 60);
    for (std::size_t i = 1; i < lines.size(); ++i)
      CHECK(lines[i].segment.length_px() <= lines[i - 1].segment.length_px() + 8.0);
  }

  TEST_CASE("the worst pictures of a large sensor take bounded time") {
    OwnedDetector detector(plain_camera(640, 480));
    std::mt19937_64 random(3);
    const GreyImage noise =
        draw(640, 480, [&](double, double) { return 255.0 * support::uniform(random); });
    const GreyImage boxes = draw(640, 480, [](double x, double y) {
      const bool left = std::fmod(x + 50.0, 30.0) < 15.0;
      return left != (std::fmod(y + 50.0, 30.0) < 15.0) ? 220.0 : 30.0;
    });
    const GreyImage rings = draw(640, 480, [](double x, double y) {
      return 128.0 + 127.0 * std::sin(0.8 * std::hypot(x - 320.0, y - 240.0));
    });
    for (const GreyImage* image : {&noise, &boxes, &rings}) {
      const std::clock_t start = std::clock();
      CHECK(detector.detect(*image).size() <= 60);
      // Processor time, a hundred times what is usual: the sanitizers and a busy machine pass.
      CHECK(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC < 5.0);
    }
  }

  TEST_CASE("pictures without edges have no lines") {
    for (const LinePicture kind :
         {LinePicture::kGrey, LinePicture::kSurface, LinePicture::kSignedSurface}) {
      OwnedDetector detector(plain_camera(kWidth, kHeight), kind);
      for (const double grey : {0.0, 128.0, 255.0})
        CHECK(detector.detect(draw(kWidth, kHeight, [&](double, double) { return grey; })).empty());
      CHECK(
          detector.detect(draw(kWidth, kHeight, [](double x, double) { return 0.5 * x; })).empty());
    }
  }

  TEST_CASE("edges that leave the picture end inside it") {
    OwnedDetector detector(plain_camera(kWidth, kHeight));
    for (const double slope : {-0.7, 0.0, 0.02, 0.9}) {
      CAPTURE(slope);
      const GreyImage image = draw(kWidth, kHeight, [&](double x, double y) {
        return y > 90.0 + slope * (x - 120.0) ? 200.0 : 50.0;
      });
      const DetectedLines lines = detector.detect(image);
      REQUIRE(lines.size() == 1);
      check_bounds(lines, 1);
      CHECK(support::off_line_px(lines[0].segment, {120, 90}, {220, 90 + 100 * slope}) < 0.2);
      CHECK(lines[0].segment.length_px() > 150.0);
    }
    const GreyImage rim =
        draw(kWidth, kHeight, [](double x, double) { return x > 1.5 ? 9.0 : 200; });
    check_bounds(detector.detect(rim), 1);
  }

  TEST_CASE("a picture of another size is refused") {
    OwnedDetector detector(plain_camera(kWidth, kHeight));
    DetectedLines lines;
    REQUIRE(lines.push_back({}));
    CHECK_FALSE(detector.detector().detect(GreyImage(120, 90).view(), lines));
    CHECK(lines.empty());
    CHECK_FALSE(detector.detector().detect({}, lines));
  }

  TEST_CASE("a picture with a longer stride gives the same lines") {
    const Rectangle r({121.3, 88.7}, 52.0, 37.0, 0.3);
    const GreyImage image = draw_rectangle(r);
    GreyImage wide(300, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < 300; ++x)
        wide.at(y, x) = x < kWidth ? image.view().at(y, x) : static_cast<std::uint8_t>(7 * x);
    OwnedDetector detector(plain_camera(kWidth, kHeight));
    const DetectedLines plain = detector.detect(image);
    DetectedLines strided;
    REQUIRE(detector.detector().detect({wide.pixels.data(), kWidth, kHeight, 300}, strided));
    REQUIRE(strided.size() == plain.size());
    for (std::size_t i = 0; i < plain.size(); ++i) {
      CHECK(strided[i].raw_px == plain[i].raw_px);
      CHECK(strided[i].descriptor == plain[i].descriptor);
    }
  }
}

}  // namespace pled
