#include "pled_vins/reliability/bin_clock.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "support/reliability/score_by_definition.hpp"

namespace pled {
namespace {

constexpr Duration kWidth{4096};
constexpr std::int64_t kWindow_us = 8 * kWidth.us;
constexpr std::int64_t kStart_us = 1'700'000'000'123'456;  // a stamp of today's epoch

/// The bins of the window that ends with `last`, oldest first, as the clock has them after the
/// frame at `t`.
std::vector<TimeBin> window(const BinClock& clock, Timestamp t, BinNumber last) {
  std::vector<TimeBin> bins;
  TimeBin bin = clock.bin_of(t);
  while (bin.number > last) bin = clock.bin_of(bin.begin);
  for (std::size_t k = 0; k < limits::kTimeBins; ++k) {
    bins.insert(bins.begin(), bin);
    bin = clock.bin_of(bin.begin);
  }
  return bins;
}

std::int64_t length_us(const TimeBin& bin) { return (bin.end - bin.begin).us; }

/// Frames, so many that the clock knew their period all through the window, then one `late_us`
/// after its time.
constexpr int kFrames = 12;
std::vector<TimeBin> window_at(std::int64_t period_us, std::int64_t late_us) {
  BinClock clock(kWidth);
  for (int i = 0; i < kFrames; ++i) clock.on_frame({kStart_us + i * period_us});
  const Timestamp t{kStart_us + kFrames * period_us + late_us};
  const BinNumber last = clock.on_frame(t);
  return window(clock, t, last);
}

}  // namespace

TEST_SUITE("reliability.bin_clock") {
  TEST_CASE("an instant at the end of a bin belongs to it, the next one does not") {
    const BinClock clock(kWidth);
    for (const std::int64_t k : {-3, -1, 0, 1, 100}) {
      const std::int64_t end_us = (k + 1) * kWidth.us;
      CHECK(clock.bin_of({end_us}).number == k);
      CHECK(clock.bin_of({end_us}).end.us == end_us);
      CHECK(clock.bin_of({end_us}).begin.us == end_us - kWidth.us);
      CHECK(clock.bin_of({end_us + 1}).number == k + 1);
    }
  }

  TEST_CASE("bins follow each other without gap or overlap, whatever the frames do") {
    std::mt19937_64 random(1);
    for (int run = 0; run < 50; ++run) {
      CAPTURE(run);
      BinClock clock(kWidth);
      std::int64_t t_us = kStart_us;
      for (int i = 0; i < 40; ++i) {
        const std::int64_t next_us = t_us + 1 + static_cast<std::int64_t>(random() % 80'000);
        if (random() % 3 == 0) {
          const auto binned_us = t_us + static_cast<std::int64_t>(random() % 3'000);
          clock.expect_frame({next_us}, {binned_us});
        }
        t_us = next_us;
        const TimeBin open = clock.bin_of({t_us});  // in which events may have been counted
        const BinNumber last = clock.on_frame({t_us});
        REQUIRE(last <= open.number);
        REQUIRE(last >= open.number - 1);
        REQUIRE(clock.bin_of({t_us}).number == open.number);
        REQUIRE(clock.bin_of({t_us}).begin == open.begin);
      }
      TimeBin bin = clock.bin_of({t_us + 50'000});
      while (bin.end.us > t_us - 200'000) {
        REQUIRE(length_us(bin) > 0);
        REQUIRE(clock.bin_of({bin.begin.us + 1}).number == bin.number);
        REQUIRE(clock.bin_of(bin.end).number == bin.number);
        const TimeBin before = clock.bin_of(bin.begin);
        REQUIRE(before.number < bin.number);
        REQUIRE(before.end == bin.begin);
        bin = before;
      }
    }
  }

  TEST_CASE(
      "with frames further apart than the window, it is exactly the B bins before the frame") {
    for (const std::int64_t period_us : {kWindow_us, kWindow_us + 1, std::int64_t{33'333},
                                         std::int64_t{50'000}, std::int64_t{100'000}}) {
      CAPTURE(period_us);
      const std::vector<TimeBin> bins = window_at(period_us, 0);
      CHECK(bins.back().end.us == kStart_us + kFrames * period_us);
      for (const TimeBin& bin : bins) CHECK(length_us(bin) == kWidth.us);
    }
  }

  TEST_CASE(
      "with frames closer than the window, bins are equal, near the width, and end at frames") {
    for (const std::int64_t period_us : {4'000, 5'000, 10'000, 16'667, 20'000, 30'000, 32'767}) {
      CAPTURE(period_us);
      const double k = std::max(1.0, std::round(static_cast<double>(period_us) / 4096.0));
      const std::vector<TimeBin> bins = window_at(period_us, 0);
      CHECK(bins.back().end.us == kStart_us + kFrames * period_us);
      for (const TimeBin& bin : bins) {
        CHECK(std::abs(static_cast<double>(length_us(bin) - kWidth.us)) <= 4096.0 / (2.0 * k) + k);
        CHECK(std::abs(length_us(bin) - length_us(bins.back())) <= static_cast<int>(k));
      }
    }
  }

  TEST_CASE("frames faster than half a bin shorten the window to B periods") {
    constexpr std::int64_t kPeriod_us = 1'000;
    BinClock clock(kWidth);
    BinNumber last = 0;
    Timestamp t;
    for (int i = 0; i < 30; ++i) {
      t = {kStart_us + i * kPeriod_us};
      last = clock.on_frame(t);
    }
    const std::vector<TimeBin> bins = window(clock, t, last);
    CHECK(bins.back().end == t);
    CHECK((bins.back().end - bins.front().begin).us == 8 * kPeriod_us);
  }

  TEST_CASE(
      "a frame late by up to a quarter of a bin reads the window that ended where it was due") {
    for (const std::int64_t late_us : {1, 10, 500, 1024}) {
      CAPTURE(late_us);
      const std::vector<TimeBin> bins = window_at(50'000, late_us);
      CHECK(bins.back().end.us == kStart_us + kFrames * 50'000);
      for (const TimeBin& bin : bins) CHECK(length_us(bin) == kWidth.us);
    }
  }

  TEST_CASE("a frame before its time ends the newest bin early, the rest are as planned") {
    for (const std::int64_t early_us : {1, 10, 500, 1024, 3'000}) {
      CAPTURE(early_us);
      const std::vector<TimeBin> bins = window_at(50'000, -early_us);
      CHECK(bins.back().end.us == kStart_us + kFrames * 50'000 - early_us);
      CHECK(length_us(bins.back()) == kWidth.us - early_us);
      for (std::size_t i = 0; i < 7; ++i) CHECK(length_us(bins[i]) == kWidth.us);
    }
  }

  TEST_CASE(
      "whenever a frame comes, its window ends within a quarter of a bin and opens no sliver") {
    std::mt19937_64 random(2);
    for (int i = 0; i < 2000; ++i) {
      // From the earliest that leaves the short bin behind, on to two missed frames.
      const auto late_us = static_cast<std::int64_t>(random() % 116'000) - 15'000;
      CAPTURE(late_us);
      const std::vector<TimeBin> bins = window_at(50'000, late_us);
      const std::int64_t t_us = kStart_us + kFrames * 50'000 + late_us;
      CHECK(bins.back().end.us <= t_us);
      CHECK(bins.back().end.us >= t_us - kWidth.us / 4);
      CHECK(length_us(bins.back()) > kWidth.us / 4);
      CHECK(length_us(bins.back()) <= kWidth.us);
      const std::int64_t far_us = bins.front().begin.us - (t_us - kWindow_us);
      CHECK(far_us >= -kWidth.us / 4);
      CHECK(far_us <= kWidth.us * 3 / 4);
    }
  }

  TEST_CASE("with each frame known beforehand, every window is exact, however irregular they are") {
    std::mt19937_64 random(3);
    BinClock clock(kWidth);
    Timestamp t{kStart_us};
    clock.on_frame(t);
    for (int i = 0; i < 500; ++i) {
      // Sometimes only after some events of the interval were put into bins.
      const Timestamp binned{t.us + static_cast<std::int64_t>(random() % 2 * (random() % 8'000))};
      const Timestamp next{binned.us + kWindow_us + kWidth.us +
                           static_cast<std::int64_t>(random() % 60'000)};
      const TimeBin begun = clock.bin_of(binned);
      REQUIRE(clock.expect_frame(next, binned));
      REQUIRE(clock.bin_of(binned).number == begun.number);
      REQUIRE(clock.bin_of(binned).begin == begun.begin);
      t = next;
      const BinNumber last = clock.on_frame(t);
      const std::vector<TimeBin> bins = window(clock, t, last);
      REQUIRE(bins.back().end == t);
      for (const TimeBin& bin : bins) REQUIRE(length_us(bin) == kWidth.us);
    }
  }

  TEST_CASE("an announcement in the past, and a frame before the last, change nothing") {
    BinClock clock(kWidth);
    clock.on_frame({kStart_us});
    clock.on_frame({kStart_us + 50'000});
    const TimeBin before = clock.bin_of({kStart_us + 80'000});
    CHECK_FALSE(clock.expect_frame({kStart_us + 60'000}, {kStart_us + 60'000}));
    CHECK_FALSE(clock.expect_frame({kStart_us + 60'000}, {kStart_us + 49'999}));
    CHECK(clock.on_frame({kStart_us + 40'000}) == clock.bin_of({kStart_us + 40'000}).number);
    const TimeBin after = clock.bin_of({kStart_us + 80'000});
    CHECK(after.number == before.number);
    CHECK(after.begin == before.begin);
    CHECK(after.end == before.end);
  }

  TEST_CASE("events counted by the clock's bins score as the paper's window does, at every frame") {
    std::mt19937_64 random(4);
    const ScoreTables tables(2.0);
    for (const std::int64_t period_us : {33'333, 50'000}) {
      CAPTURE(period_us);
      constexpr int kSide = 6;
      std::vector<BinCell> cells(BinCounters::cells_needed(kSide, kSide));
      BinCounters counters(kSide, kSide, cells);
      BinClock clock(kWidth);
      std::vector<support::TimedPixel> events;
      std::int64_t t_us = kStart_us;
      double worst = 0.0;
      std::size_t scores = 0;
      for (int frame = 0; frame < 40; ++frame) {
        const Timestamp t_frame{kStart_us + frame * period_us};
        for (; t_us <= t_frame.us; t_us += static_cast<std::int64_t>(random() % 200)) {
          const WarpedPixel at{static_cast<std::int16_t>(random() % kSide),
                               static_cast<std::int16_t>(random() % kSide)};
          events.push_back({{t_us}, at});
          counters.add({&at, 1}, clock.bin_of({t_us}).number);
        }
        const BinNumber last = clock.on_frame(t_frame);
        if (frame < 2) continue;  // the period is not known yet
        const support::BatchCounts batch = support::batch_counts(events, t_frame, kWidth);
        for (const auto& [at, want] : batch) {
          const PixelScore got = tables.score(counters.counts_at(at.first, at.second, last));
          const PixelScore exact = support::score_by_definition(want, 2.0, kPaperEpsilon);
          CHECK(got.n == exact.n);
          worst = std::max({worst, std::abs(got.h - exact.h), std::abs(got.q - exact.q),
                            std::abs(got.s - exact.s)});
          ++scores;
        }
      }
      CHECK(scores > 1000);
      CHECK(worst < 1e-6);
    }
  }
}
}  // namespace pled
