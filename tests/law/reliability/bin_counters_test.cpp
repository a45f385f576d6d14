#include "pled_vins/reliability/bin_counters.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

namespace pled {
namespace {

constexpr int kWidth = 4;
constexpr int kHeight = 3;
constexpr BinNumber kB = limits::kTimeBins;

/// Every count of every pixel and bin, kept for ever.
class SlowCounters {
 public:
  void add(WarpedPixel at, BinNumber bin) {
    newest_ = std::max(newest_, bin);
    if (newest_ - bin >= kB) return;
    Pixel& pixel = pixels_[{at.x_px, at.y_px}];
    pixel.newest = std::max(pixel.newest, bin);
    int& count = pixel.counts[bin];
    count = std::min(count + 1, 255);
  }

  [[nodiscard]] BinCounts counts_at(int x, int y, BinNumber last) const {
    BinCounts out{};
    const auto found = pixels_.find({x, y});
    if (found == pixels_.end()) return out;
    for (const auto& [bin, count] : found->second.counts) {
      const BinNumber age = last - bin;
      // A bin that a newer event of the pixel has pushed out is gone.
      if (age < 0 || age >= kB || found->second.newest - bin >= kB) continue;
      out[static_cast<std::size_t>(kB - 1 - age)] = static_cast<std::uint8_t>(count);
    }
    return out;
  }

  [[nodiscard]] BinNumber newest() const { return newest_; }

 private:
  struct Pixel {
    std::map<BinNumber, int> counts;
    BinNumber newest = -1'000'000'000;
  };
  std::map<std::pair<int, int>, Pixel> pixels_;
  BinNumber newest_ = -1'000'000'000;
};

struct Step {
  WarpedPixel at;
  BinNumber bin = 0;
};

/// Busy stretches, bursts beyond 255 in a bin, late events, pauses, and jumps of up to a little
/// more than `max_jump` bins.
std::vector<Step> random_history(std::uint64_t seed, BinNumber max_jump) {
  std::mt19937_64 random(seed);
  const auto below = [&](std::int64_t n) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n));
  };
  std::vector<Step> steps;
  BinNumber bin = below(1'000'000) - 500'000;
  while (steps.size() < 6000) {
    const std::int64_t kind = below(1000);
    if (kind < 300) bin += below(3);
    if (kind >= 300 && kind < 320) bin += below(20);
    if (kind >= 320 && kind < 324) bin += 1 + below(max_jump);
    // Only here and there, so that many pixels rest through the jumps.
    const WarpedPixel at{static_cast<std::int16_t>(below(kWidth)),
                         static_cast<std::int16_t>(below(kHeight))};
    const BinNumber late = below(10) == 0 ? below(12) : 0;
    const std::int64_t repeat = below(400) == 0 ? 300 : 1;
    for (std::int64_t i = 0; i < repeat; ++i) steps.push_back({at, bin - late});
  }
  return steps;
}

struct Grid {
  std::vector<BinCell> cells = std::vector<BinCell>(BinCounters::cells_needed(kWidth, kHeight));
  BinCounters counters{kWidth, kHeight, cells};
};

/// Hands over steps in calls of one bin each, cut anew wherever `cut` says so.
template <typename Cut>
void play(const std::vector<Step>& steps, BinCounters& counters, const Cut& cut) {
  std::vector<WarpedPixel> run;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    run.push_back(steps[i].at);
    if (i + 1 < steps.size() && steps[i + 1].bin == steps[i].bin && !cut(i)) continue;
    counters.add(run, steps[i].bin);
    run.clear();
  }
}

bool same_cells(const Grid& a, const Grid& b) {
  return std::equal(a.cells.begin(), a.cells.end(), b.cells.begin(),
                    [](const BinCell& x, const BinCell& y) { return x.bytes == y.bytes; });
}

}  // namespace

TEST_SUITE("reliability.bin_counters") {
  TEST_CASE("counts equal those of a record of everything, after any history") {
    // Jumps to just beyond the sweep's period, the half and the whole range of the 16-bit stamp.
    for (const BinNumber max_jump : {12, 16'000, 17'000, 33'000, 66'000, 200'000}) {
      for (const std::uint64_t seed : {1U, 2U, 3U}) {
        CAPTURE(max_jump);
        CAPTURE(seed);
        Grid fast;
        SlowCounters want;
        bool equal = true;
        std::size_t compared = 0;
        for (const Step& step : random_history(seed, max_jump)) {
          fast.counters.add({&step.at, 1}, step.bin);
          want.add(step.at, step.bin);
          if (++compared % 7 != 0) continue;
          for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < kWidth; ++x) {
              for (const BinNumber last : {want.newest() - 1, want.newest(), want.newest() + 3})
                equal &= fast.counters.counts_at(x, y, last) == want.counts_at(x, y, last);
            }
          }
        }
        CHECK(equal);
        CHECK(fast.counters.losses().saturated > 0);
        CHECK(fast.counters.losses().late > 0);
      }
    }
  }

  TEST_CASE("no resting pixel comes back to life when its stamp wraps") {
    for (const BinNumber step : {1, 7, 4099, 16'383}) {
      CAPTURE(step);
      Grid grid;
      const WarpedPixel at{1, 1};
      const BinNumber start = 12'345;
      grid.counters.add({&at, 1}, start);
      bool silent = true;
      for (BinNumber bin = start; bin < start + 3 * 65'536;) {
        bin += step;
        grid.counters.advance_to(bin);
        const BinCounts counts = grid.counters.counts_at(1, 1, bin);
        if (bin - start >= kB) silent &= counts == BinCounts{};
      }
      CHECK(silent);
      // Nor does its old stamp make a new event look late.
      const BinNumber now = grid.counters.newest();
      grid.counters.add({&at, 1}, now);
      CHECK(grid.counters.counts_at(1, 1, now) == BinCounts{0, 0, 0, 0, 0, 0, 0, 1});
    }
  }

  TEST_CASE("how a stream is cut into calls changes nothing, not even a loss") {
    for (const std::uint64_t seed : {4U, 5U, 6U}) {
      CAPTURE(seed);
      const std::vector<Step> steps = random_history(seed, 20'000);
      Grid whole;
      Grid single;
      Grid mixed;
      std::mt19937_64 random(seed);
      play(steps, whole.counters, [](std::size_t) { return false; });
      play(steps, single.counters, [](std::size_t) { return true; });
      play(steps, mixed.counters, [&](std::size_t) { return random() % 5 == 0; });
      CHECK(same_cells(whole, single));
      CHECK(same_cells(whole, mixed));
      const BinCounterLosses& a = whole.counters.losses();
      const BinCounterLosses& b = single.counters.losses();
      CHECK(a.late == b.late);
      CHECK(a.saturated == b.saturated);
      CHECK(a.late + a.saturated > 0);
    }
  }

  TEST_CASE("the order of events within a bin does not matter") {
    std::vector<Step> steps = random_history(7, 16'000);
    std::stable_sort(steps.begin(), steps.end(),
                     [](const Step& a, const Step& b) { return a.bin < b.bin; });
    std::vector<Step> shuffled = steps;
    std::mt19937_64 random(8);
    for (auto begin = shuffled.begin(); begin != shuffled.end();) {
      const auto end =
          std::find_if(begin, shuffled.end(), [&](const Step& s) { return s.bin != begin->bin; });
      std::shuffle(begin, end, random);
      begin = end;
    }
    Grid a;
    Grid b;
    play(steps, a.counters, [](std::size_t) { return false; });
    play(shuffled, b.counters, [](std::size_t) { return false; });
    CHECK(same_cells(a, b));
  }
}
}  // namespace pled
