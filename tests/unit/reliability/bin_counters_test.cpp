#include "pled_vins/reliability/bin_counters.hpp"

#include <array>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

namespace pled {
namespace {

constexpr int kWidth = 5;
constexpr int kHeight = 3;

struct Fixture {
  // Poisoned: the counters must not rely on cleared memory.
  std::vector<BinCell> cells = std::vector<BinCell>(BinCounters::cells_needed(kWidth, kHeight),
                                                    BinCell{{9, 9, 9, 9, 9, 9, 9, 9, 9, 9}});
  BinCounters counters{kWidth, kHeight, cells};

  void add(int times, BinNumber bin, int x = 2, int y = 1) {
    const WarpedPixel at{static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)};
    const std::vector<WarpedPixel> events(static_cast<std::size_t>(times), at);
    counters.add(events, bin);
  }
};

}  // namespace

TEST_SUITE("reliability.bin_counters") {
  TEST_CASE_FIXTURE(Fixture, "counts come oldest first and slide with the window") {
    add(1, 100);
    add(2, 101);
    add(3, 107);
    CHECK(counters.counts_at(2, 1, 107) == BinCounts{1, 2, 0, 0, 0, 0, 0, 3});
    CHECK(counters.counts_at(2, 1, 108) == BinCounts{2, 0, 0, 0, 0, 0, 3, 0});
    CHECK(counters.counts_at(2, 1, 114) == BinCounts{3, 0, 0, 0, 0, 0, 0, 0});
    CHECK(counters.counts_at(2, 1, 115) == BinCounts{});
    CHECK(counters.counts_at(1, 1, 107) == BinCounts{});
  }

  TEST_CASE_FIXTURE(Fixture, "a full counter stops and says so, its neighbours go on") {
    add(255, 100);
    CHECK(counters.losses().saturated == 0);
    add(3, 100);
    add(1, 101);
    CHECK(counters.losses().saturated == 3);
    CHECK(counters.counts_at(2, 1, 101) == BinCounts{0, 0, 0, 0, 0, 0, 255, 1});
  }

  TEST_CASE_FIXTURE(Fixture, "a late event fills up its own bin to 255 as well") {
    add(1, 105);
    add(300, 103);
    CHECK(counters.losses().saturated == 45);
    CHECK(counters.counts_at(2, 1, 105) == BinCounts{0, 0, 0, 0, 0, 255, 0, 1});
  }

  TEST_CASE_FIXTURE(Fixture,
                    "late events within the window go to their bin, older ones are dropped") {
    add(1, 110);
    add(2, 103);
    add(4, 102);
    CHECK(counters.counts_at(2, 1, 110) == BinCounts{2, 0, 0, 0, 0, 0, 0, 1});
    CHECK(counters.losses().late == 4);
    add(5, 104, 1, 1);  // a pixel without newer events
    CHECK(counters.counts_at(1, 1, 110) == BinCounts{0, 5, 0, 0, 0, 0, 0, 0});
    CHECK(counters.newest() == 110);
  }

  TEST_CASE_FIXTURE(Fixture,
                    "a window that ended before a pixel's newest bin has lost its oldest bins") {
    add(1, 100);
    add(2, 107);
    add(4, 108);
    CHECK(counters.counts_at(2, 1, 107) == BinCounts{0, 0, 0, 0, 0, 0, 0, 2});
    CHECK(counters.counts_at(2, 1, 99) == BinCounts{});
  }

  TEST_CASE_FIXTURE(Fixture, "events at the corners of the grid count, those beyond are refused") {
    add(1, 100, 0, 0);
    add(1, 100, kWidth - 1, kHeight - 1);
    CHECK(counters.losses().outside == 0);
    CHECK(counters.counts_at(0, 0, 100)[7] == 1);
    CHECK(counters.counts_at(kWidth - 1, kHeight - 1, 100)[7] == 1);
    constexpr int kHigh = std::numeric_limits<std::int16_t>::max();
    for (const BinNumber bin : {100, 99}) {  // the newest, and a late one
      add(1, bin, -1, 0);
      add(1, bin, kWidth, 0);
      add(1, bin, 0, -1);
      add(1, bin, 0, kHeight);
      add(1, bin, kOutsideGrid.x_px, kOutsideGrid.y_px);
      add(1, bin, kHigh, kHigh);
    }
    CHECK(counters.losses().outside == 12);
    CHECK_FALSE(counters.contains(kWidth, 0));
    CHECK(counters.counts_at(kWidth, 0, 100) == BinCounts{});
    CHECK(counters.counts_at(-1, 0, 100) == BinCounts{});
  }

  TEST_CASE_FIXTURE(Fixture, "clear forgets events, losses and how late it was") {
    add(300, 100000);
    counters.clear();
    CHECK(counters.losses().saturated == 0);
    CHECK(counters.counts_at(2, 1, 100000) == BinCounts{});
    add(1, 7);
    CHECK(counters.counts_at(2, 1, 7)[7] == 1);
    CHECK(counters.losses().late == 0);
  }

  TEST_CASE_FIXTURE(Fixture, "bin numbers may be negative") {
    add(1, -9);
    add(2, -3);
    add(3, 1);
    CHECK(counters.counts_at(2, 1, -2) == BinCounts{0, 0, 0, 0, 0, 0, 2, 0});
    CHECK(counters.counts_at(2, 1, 1) == BinCounts{0, 0, 0, 2, 0, 0, 0, 3});
  }
}
}  // namespace pled
