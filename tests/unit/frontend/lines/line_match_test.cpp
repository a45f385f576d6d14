#include "pled_vins/frontend/lines/line_match.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "support/frontend/plane_scene.hpp"

namespace pled {
namespace {

LineDescriptor random_bits(std::mt19937_64& random) {
  LineDescriptor d;
  for (std::uint64_t& word : d.bits) word = random();
  return d;
}

/// The same with `count` bits turned over.
LineDescriptor differing(LineDescriptor d, int count) {
  for (int i = 0; i < count; ++i)
    d.bits[static_cast<std::size_t>(i % 4)] ^= std::uint64_t{1} << (i / 4);
  return d;
}

ExpectedLine expected_at(double x0, double y0, double x1, double y1,
                         const LineDescriptor& descriptor = {}) {
  ExpectedLine line;
  line.segment.set({x0, y0}, {x1, y1});
  line.descriptor = descriptor;
  return line;
}

DetectedLine seen_at(double x0, double y0, double x1, double y1,
                     const LineDescriptor& descriptor = {}) {
  DetectedLine line;
  line.segment.set({x0, y0}, {x1, y1});
  line.descriptor = descriptor;
  return line;
}

std::vector<std::int16_t> match(const std::vector<ExpectedLine>& expected,
                                const std::vector<DetectedLine>& seen, double search_px = 8.0) {
  std::vector<std::int16_t> out(expected.size(), 99);
  match_lines(expected, seen, search_px, out);
  return out;
}

using Matches = std::vector<std::int16_t>;

}  // namespace

TEST_SUITE("frontend.line_match") {
  TEST_CASE("shuffled lines of which the ends slid and a few left or came find each other") {
    std::mt19937_64 random(1);
    std::vector<ExpectedLine> expected;
    std::vector<DetectedLine> seen;
    for (int i = 0; i < 20; ++i) {
      const double y = 8.0 * i + 10.0;
      const LineDescriptor d = random_bits(random);
      const double slide = 10.0 * support::uniform(random);
      if (i != 3) expected.push_back(expected_at(40, y, 200, y, d));
      if (i != 7)
        seen.push_back(seen_at(40 + slide, y + 1.5, 200 + slide, y - 1.0, differing(d, 30)));
    }
    std::vector<std::size_t> order(seen.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), random);
    std::vector<DetectedLine> shuffled;
    for (const std::size_t k : order) shuffled.push_back(seen[k]);
    const Matches got = match(expected, shuffled);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CAPTURE(i);
      const double y = expected[i].segment.start_px[1];
      if (y == 8.0 * 7 + 10.0) {
        CHECK(got[i] == kNoLine);
        continue;
      }
      REQUIRE(got[i] != kNoLine);
      CHECK(shuffled[static_cast<std::size_t>(got[i])].segment.start_px[1] == y + 1.5);
    }
  }

  TEST_CASE("what is too far, turned, beside, the other way round or of other events is no match") {
    const std::vector<ExpectedLine> line{expected_at(40, 50, 120, 50)};
    CHECK(match(line, {seen_at(40, 57.9, 120, 57.9)}) == Matches{0});
    CHECK(match(line, {seen_at(40, 58.1, 120, 58.1)}) == Matches{kNoLine});
    CHECK(match(line, {seen_at(40, 53.9, 120, 46.1)}) == Matches{0});        // 5.6 degrees
    CHECK(match(line, {seen_at(40, 54.4, 120, 45.6)}) == Matches{kNoLine});  // 6.3 degrees
    CHECK(match(line, {seen_at(79, 50, 159, 50)}) == Matches{0});            // 41 of 80 px
    CHECK(match(line, {seen_at(81, 50, 161, 50)}) == Matches{kNoLine});      // 39
    CHECK(match(line, {seen_at(70, 50, 90, 50)}) == Matches{0});             // part of it
    CHECK(match(line, {seen_at(120, 50, 40, 50)}) == Matches{kNoLine});
    DetectedLine dark = seen_at(40, 50, 120, 50);
    dark.segment.active_is_bright = false;
    CHECK(match(line, {dark}) == Matches{kNoLine});
    const double nan = std::nan("");
    CHECK(match(line, {seen_at(nan, 50, 120, 50)}) == Matches{kNoLine});
    CHECK(match(line, {}) == Matches{kNoLine});
    CHECK(match({}, {dark}).empty());
  }

  TEST_CASE("the nearest is taken when it is nearer by two pixels, whatever the descriptors say") {
    std::mt19937_64 random(2);
    const LineDescriptor d = random_bits(random);
    const std::vector<ExpectedLine> line{expected_at(40, 50, 120, 50, d)};
    CHECK(match(line, {seen_at(40, 53.1, 120, 53.1, d),
                       seen_at(40, 49, 120, 49, differing(d, 60))}) == Matches{1});
  }

  TEST_CASE("of several as near the descriptor chooses, or none is taken") {
    std::mt19937_64 random(3);
    const LineDescriptor d = random_bits(random);
    const std::vector<ExpectedLine> line{expected_at(40, 50, 120, 50, d)};
    const auto two = [&](int first, int second) {
      return match(line, {seen_at(40, 51, 120, 51, differing(d, first)),
                          seen_at(40, 49, 120, 49, differing(d, second))});
    };
    CHECK(two(60, 20) == Matches{1});
    CHECK(two(39, 49) == Matches{0});
    CHECK(two(39, 48) == Matches{kNoLine});  // alike
    CHECK(two(40, 90) == Matches{kNoLine});  // like neither
  }

  TEST_CASE("alone, a line is refused only when it looks like something else") {
    std::mt19937_64 random(4);
    const LineDescriptor d = random_bits(random);
    const std::vector<ExpectedLine> line{expected_at(40, 50, 120, 50, d)};
    CHECK(match(line, {seen_at(40, 51, 120, 51, differing(d, 99))}) == Matches{0});
    CHECK(match(line, {seen_at(40, 51, 120, 51, differing(d, 100))}) == Matches{kNoLine});
  }

  TEST_CASE("one line seen goes to one expected line, and to none when two claim it alike") {
    const std::vector<DetectedLine> seen{seen_at(40, 50, 120, 50)};
    CHECK(match({expected_at(40, 50.2, 120, 50.2), expected_at(40, 53, 120, 53)}, seen) ==
          Matches{0, kNoLine});
    CHECK(match({expected_at(40, 49, 120, 49), expected_at(40, 51, 120, 51)}, seen) ==
          Matches{kNoLine, kNoLine});
  }

  TEST_CASE("a line that was missing does not make one that was seen ambiguous") {
    std::vector<ExpectedLine> lines{expected_at(40, 50, 120, 50), expected_at(40, 51, 120, 51)};
    lines[0].was_seen = false;
    CHECK(match(lines, {seen_at(40, 50.5, 120, 50.5)}) == Matches{kNoLine, 0});
    CHECK(match(lines, {seen_at(40, 51, 120, 51), seen_at(40, 48, 120, 48)}) == Matches{1, 0});
  }

  TEST_CASE("lists may be full") {
    std::vector<ExpectedLine> expected;
    std::vector<DetectedLine> seen;
    for (std::size_t i = 0; i < limits::kMaxLines; ++i) {
      const double y = 4.0 * static_cast<double>(i);
      expected.push_back(expected_at(40, y, 120, y));
      seen.push_back(seen_at(40, y + 0.5, 120, y + 0.5));
    }
    const Matches got = match(expected, seen);
    for (std::size_t i = 0; i < got.size(); ++i) CHECK(got[i] == static_cast<std::int16_t>(i));
  }
}

}  // namespace pled
