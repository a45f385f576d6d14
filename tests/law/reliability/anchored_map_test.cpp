#include "pled_vins/reliability/anchored_map.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/reliability/bin_clock.hpp"
#include "support/reliability/score_by_definition.hpp"

namespace pled {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 4;
constexpr Duration kBin{4096};
constexpr std::int64_t kPeriod_us = 40'000;

/// A picture that slides along x by a path in time: a stand-in for a turning camera whose warp can
/// be written in one line.
class SlidingPicture {
 public:
  SlidingPicture(double speed_pxps, double swing_px) : speed_(speed_pxps), swing_(swing_px) {}
  [[nodiscard]] double at(Timestamp t) const {
    return speed_ * t.seconds() + swing_ * std::sin(30.0 * t.seconds());
  }
  /// Where an event is seen in the picture of t_reference.
  [[nodiscard]] WarpedPixel warp(const support::TimedPixel& e, Timestamp t_reference) const {
    const double x = e.at.x_px + at(t_reference) - at(e.t);
    return {static_cast<std::int16_t>(std::floor(x + 0.5)), e.at.y_px};
  }

 private:
  double speed_;
  double swing_;
};

struct Run {
  std::vector<BinCell> a = std::vector<BinCell>(BinCounters::cells_needed(kWidth, kHeight));
  std::vector<BinCell> b = a;
  AnchoredMap map{ReliabilityConfig{}, kWidth, kHeight, {{a, b}}};
  BinClock clock{kBin};
  std::vector<support::TimedPixel> events;
  std::int64_t t_us = 0;
  BinNumber begun = std::numeric_limits<BinNumber>::min();
  std::set<std::int64_t> references;

  void take(const support::TimedPixel& event, const SlidingPicture& picture, double shift_px) {
    const TimeBin bin = clock.bin_of(event.t);
    if (bin.number > begun) map.begin_bin(bin.number, bin.begin, shift_px);
    begun = std::max(begun, bin.number);
    events.push_back(event);
    for (const AnchorTarget& target : map.targets()) {
      const WarpedPixel at = picture.warp(event, target.t_reference);
      map.add(target, {&at, 1}, bin.number);
    }
  }

  /// Events up to the frame, then compares every pixel of the map with the definition, applied to
  /// all events warped to the anchor that is read. @returns pixels that differ
  std::size_t compare_at(Timestamp t_frame, const SlidingPicture& picture) {
    const BinNumber last = clock.on_frame(t_frame);
    const Timestamp reference = map.reference().value();
    references.insert(reference.us);
    std::vector<support::TimedPixel> warped;
    for (const support::TimedPixel& e : events) warped.push_back({e.t, picture.warp(e, reference)});
    const support::BatchCounts want = support::batch_counts(warped, t_frame, kBin);
    std::size_t different = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const auto found = want.find({x, y});
        const support::SlowCounts expected =
            found == want.end() ? support::SlowCounts{} : found->second;
        different += support::slow(map.counts_at(x, y, last)) != expected;
      }
    }
    return different;
  }
};

support::TimedPixel random_event(std::mt19937_64& random, std::int64_t t_us) {
  return {{t_us},
          {static_cast<std::int16_t>(random() % kWidth),
           static_cast<std::int16_t>(random() % kHeight)}};
}

}  // namespace

TEST_SUITE("reliability.anchored_map") {
  TEST_CASE("at every frame the map is the batch formula on events warped to its anchor") {
    std::mt19937_64 random(1);
    struct Motion {
      double speed_pxps, swing_px;
    };
    for (const Motion motion : {Motion{0, 0}, Motion{40, 0}, Motion{600, 0}, Motion{100, 12}}) {
      CAPTURE(motion.speed_pxps);
      const SlidingPicture picture(motion.speed_pxps, motion.swing_px);
      Run run;
      std::size_t different = 0;
      for (int frame = 0; frame < 60; ++frame) {
        const Timestamp t_frame{1'000'000 + frame * kPeriod_us};
        if (frame == 0) run.t_us = t_frame.us;
        for (; run.t_us <= t_frame.us; run.t_us += static_cast<std::int64_t>(random() % 300)) {
          const double shift_px =
              run.map.reference() ? picture.at({run.t_us}) - picture.at(run.map.reference().value())
                                  : 0.0;
          run.take(random_event(random, run.t_us), picture, std::abs(shift_px));
        }
        const std::size_t now = run.compare_at(t_frame, picture);
        if (frame >= 2) different += now;  // before, the clock does not know the period
      }
      CHECK(different == 0);
      CHECK(run.map.losses().late == 0);
      // Even a still picture changes anchors, by age; a fast one as often as the window allows.
      CHECK(run.references.size() >= (motion.speed_pxps > 500 ? 25U : 4U));
    }
  }

  TEST_CASE("it stays exact through any order of wishes to move on, pauses and late events") {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
      CAPTURE(seed);
      std::mt19937_64 random(seed);
      const SlidingPicture picture(250, 6);
      Run run;
      std::size_t different = 0;
      run.t_us = 1'000'000;
      for (int frame = 0; frame < 120; ++frame) {
        const Timestamp t_frame{1'000'000 + frame * kPeriod_us};
        const bool pause = random() % 10 < 3;
        for (; run.t_us <= t_frame.us; run.t_us += static_cast<std::int64_t>(random() % 400)) {
          if (pause && random() % 50 != 0) continue;
          constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
          const std::uint64_t wish = random() % 20;
          run.take(random_event(random, run.t_us), picture, wish == 0 ? kNaN : wish == 1 ? 99 : 0);
          // An event from a bin before, less than a window ago and after the map began.
          const std::int64_t late_us = run.t_us - static_cast<std::int64_t>(random() % 3'000);
          if (random() % 20 == 0 && frame > 2)
            run.take(random_event(random, late_us), picture, 0.0);
        }
        const bool any = !run.events.empty();
        const std::size_t now = any ? run.compare_at(t_frame, picture) : 0;
        if (frame >= 2) different += now;
      }
      CHECK(different == 0);
      CHECK(run.map.anchors() > 20);
    }
  }

  TEST_CASE("an anchor takes over no sooner than a whole window after it began") {
    const SlidingPicture picture(0, 0);
    std::vector<BinCell> a(BinCounters::cells_needed(kWidth, kHeight));
    std::vector<BinCell> b = a;
    AnchoredMap map(ReliabilityConfig{}, kWidth, kHeight, {{a, b}});
    CHECK(map.targets().empty());
    CHECK_FALSE(map.reference().has_value());
    CHECK_FALSE(map.read(1, 1, 0).has_value());
    map.begin_bin(100, {0}, 0.0);
    REQUIRE(map.targets().size() == 1);
    map.begin_bin(101, {4096}, 6.0);  // not beyond the limit
    CHECK(map.targets().size() == 1);
    map.begin_bin(102, {8192}, 6.1);
    REQUIRE(map.targets().size() == 2);
    CHECK(map.targets()[0].t_reference.us == 0);
    CHECK(map.targets()[1].t_reference.us == 8192);
    CHECK(map.targets()[0].grid != map.targets()[1].grid);
    for (BinNumber bin = 103; bin < 110; ++bin) {
      map.begin_bin(bin, {8192 + (bin - 102) * 4096}, 50.0);
      CHECK(map.targets().size() == 2);
      CHECK(map.reference()->us == 0);
    }
    map.begin_bin(110, {8192 + 8 * 4096}, 50.0);
    REQUIRE(map.targets().size() == 1);
    CHECK(map.reference()->us == 8192);
  }

  TEST_CASE("a shift that is not a number counts as too far") {
    std::vector<BinCell> a(BinCounters::cells_needed(kWidth, kHeight));
    std::vector<BinCell> b = a;
    AnchoredMap map(ReliabilityConfig{}, kWidth, kHeight, {{a, b}});
    map.begin_bin(0, {0}, 0.0);
    map.begin_bin(1, {4096}, std::numeric_limits<double>::quiet_NaN());
    CHECK(map.targets().size() == 2);
  }

  TEST_CASE("a frame at the end of a bin reads a whole window right after a take-over") {
    std::vector<BinCell> a(BinCounters::cells_needed(kWidth, kHeight));
    std::vector<BinCell> b = a;
    AnchoredMap map(ReliabilityConfig{}, kWidth, kHeight, {{a, b}});
    const WarpedPixel at{3, 2};
    for (BinNumber bin = 0; bin <= 9; ++bin) {
      map.begin_bin(bin, {bin * 4096}, 10.0);
      for (const AnchorTarget& target : map.targets()) map.add(target, {&at, 1}, bin);
    }
    REQUIRE(map.reference()->us == 4096);  // the second anchor, begun with bin 1
    CHECK(map.counts_at(3, 2, 9) == BinCounts{1, 1, 1, 1, 1, 1, 1, 1});
  }

  TEST_CASE("pooling takes the busiest or the mean of the active pixels among nine") {
    std::vector<BinCell> a(BinCounters::cells_needed(kWidth, kHeight));
    std::vector<BinCell> b = a;
    AnchoredMap map(ReliabilityConfig{}, kWidth, kHeight, {{a, b}});
    const auto put = [&](std::int16_t x, std::int16_t y, BinNumber bin, int times) {
      if (bin > 0) map.begin_bin(bin, {bin * 4096}, 0.0);
      const WarpedPixel at{x, y};
      for (int i = 0; i < times; ++i) map.add(map.targets()[0], {&at, 1}, bin);
    };
    map.begin_bin(0, {0}, 0.0);
    put(10, 1, 0, 2);
    put(10, 1, 7, 1);
    put(11, 2, 7, 4);
    const ScoreTables& tables = map.tables();
    const PixelScore left = tables.score({2, 0, 0, 0, 0, 0, 0, 1});
    const PixelScore right = tables.score({0, 0, 0, 0, 0, 0, 0, 4});

    CHECK(map.read(10.49, 1.49, 7)->s == left.s);
    CHECK_FALSE(map.read(10.51, 1.0, 7).has_value());  // no event: no evidence
    CHECK(map.read(10.51, 1.0, 7, ScorePooling::kMostEvents)->q == right.q);
    const PixelScore mean = map.read(10.0, 1.0, 7, ScorePooling::kMeanActive).value();
    CHECK(mean.n == 7);
    CHECK(mean.h == doctest::Approx((left.h + right.h) / 2));
    CHECK(mean.s == doctest::Approx((left.s + right.s) / 2));
    CHECK_FALSE(map.read(20.0, 1.0, 7, ScorePooling::kMeanActive).has_value());
    CHECK_FALSE(map.read(-0.51, 1.0, 7, ScorePooling::kMostEvents).has_value());
    CHECK_FALSE(map.read(kWidth - 0.4, 1.0, 7).has_value());
    CHECK_FALSE(map.read(std::numeric_limits<double>::quiet_NaN(), 1.0, 7).has_value());
    CHECK_FALSE(map.read(1.0, std::numeric_limits<double>::infinity(), 7).has_value());
  }

  TEST_CASE(
      "after a pause of a window or more it starts over at once, and after reset from anywhere") {
    std::vector<BinCell> a(BinCounters::cells_needed(kWidth, kHeight));
    std::vector<BinCell> b = a;
    AnchoredMap map(ReliabilityConfig{}, kWidth, kHeight, {{a, b}});
    const WarpedPixel at{3, 2};
    map.begin_bin(1000, {0}, 0.0);
    map.add(map.targets()[0], {&at, 1}, 1000);
    map.begin_bin(1008, {8 * 4096}, 1.0);  // the window of a frame at its begin holds bin 1000
    CHECK(map.reference()->us == 0);
    CHECK(map.counts_at(3, 2, 1007) == BinCounts{1, 0, 0, 0, 0, 0, 0, 0});
    map.begin_bin(1017, {17 * 4096}, 1.0);
    REQUIRE(map.targets().size() == 1);
    CHECK(map.reference()->us == 17 * 4096);
    CHECK(map.counts_at(3, 2, 1016) == BinCounts{});
    map.reset();
    CHECK(map.targets().empty());
    map.begin_bin(5, {77}, 0.0);  // another clock
    map.add(map.targets()[0], {&at, 1}, 5);
    CHECK(map.counts_at(3, 2, 5) == BinCounts{0, 0, 0, 0, 0, 0, 0, 1});
    CHECK(map.losses().late == 0);
  }
}
}  // namespace pled
