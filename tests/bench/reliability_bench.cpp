// What the entropy-recency map costs. bench_reliability [STAGE [WIDTHxHEIGHT]]
//
// Without arguments: nanoseconds per event of every stage at four sizes, beside those of a plain
// store per event in the same run. With a stage (floor, counters, anchored_slow, anchored_fast):
// that stage once, for callgrind, which counts instructions inside measured_* only; the number of
// events is printed to divide by. See src/reliability/README.md.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <iterator>
#include <limits>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "pled_vins/reliability/anchored_map.hpp"
#include "pled_vins/reliability/bin_clock.hpp"

namespace {

using namespace pled;

constexpr std::size_t kEvents = 1'000'000;
constexpr std::int64_t kStep_us = 1;  // 1 Mev/s, whatever the size
constexpr Duration kBin{4096};

struct Size {
  int width_px;
  int height_px;
};
constexpr Size kSizes[] = {{240, 180}, {346, 260}, {640, 480}, {1280, 720}};

/// Events of one bin, as the warp would hand them over.
struct Run {
  BinNumber bin = 0;
  Timestamp begin;
  std::span<const WarpedPixel> events;
};

struct Stream {
  int width_px = 0;  ///< of the grid
  int height_px = 0;
  std::vector<WarpedPixel> events;
  std::vector<Run> runs;
};

/// Bars that cross the picture in a tenth of a second, with 5 % of noise, on a grid with margin.
Stream make_stream(Size size) {
  Stream s;
  s.width_px = size.width_px + 2 * limits::kMapMargin_px;
  s.height_px = size.height_px + 2 * limits::kMapMargin_px;
  std::mt19937_64 random(1);
  const auto below = [&](int n) {
    return static_cast<int>(random() % static_cast<std::uint64_t>(n));
  };
  constexpr int kBars = 6;
  s.events.reserve(kEvents);
  for (std::size_t i = 0; i < kEvents; ++i) {
    const bool noise = below(20) == 0;
    const auto phase = static_cast<int>(i % 100'000);
    const int y = below(s.height_px);
    const int bar = below(kBars) * s.width_px / kBars + phase * (s.width_px / kBars) / 100'000;
    const int x = noise ? below(s.width_px) : std::min(bar + y / 8 % 3, s.width_px - 1);
    s.events.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)});
  }
  const BinClock clock(kBin);
  for (std::size_t begin = 0; begin < kEvents;) {
    const TimeBin bin = clock.bin_of({static_cast<std::int64_t>(begin) * kStep_us + 1});
    const std::size_t end = std::min(kEvents, static_cast<std::size_t>(bin.end.us / kStep_us));
    s.runs.push_back({bin.number, bin.begin, std::span(s.events).subspan(begin, end - begin)});
    begin = end;
  }
  return s;
}

#define MEASURED [[gnu::noinline]]

MEASURED void measured_floor(const Stream& s, std::vector<std::uint16_t>& surface) {
  for (const Run& run : s.runs) {
    for (const WarpedPixel& e : run.events) {
      if (static_cast<std::uint32_t>(e.x_px) >= static_cast<std::uint32_t>(s.width_px) ||
          static_cast<std::uint32_t>(e.y_px) >= static_cast<std::uint32_t>(s.height_px))
        continue;
      surface[static_cast<std::size_t>(e.y_px * s.width_px + e.x_px)] =
          static_cast<std::uint16_t>(run.bin);
    }
  }
}

MEASURED void measured_counters(const Stream& s, BinCounters& counters) {
  for (const Run& run : s.runs) counters.add(run.events, run.bin);
}

/// The picture turns by `speed_pxps` all the time. The warp itself is another stage's cost: both
/// anchors get the same pixels.
MEASURED void measured_anchored(const Stream& s, AnchoredMap& map, double speed_pxps) {
  for (const Run& run : s.runs) {
    const double turned_s = map.reference() ? (run.begin - *map.reference()).seconds() : 0.0;
    map.begin_bin(run.bin, run.begin, speed_pxps * turned_s);
    for (const AnchorTarget& target : map.targets()) map.add(target, run.events, run.bin);
  }
}

/// Processor time of this thread, so that other programs do not count.
double cpu_ns() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e9 + static_cast<double>(now.tv_nsec);
}

template <typename Work>
double timed(const Work& work) {
  const double start = cpu_ns();
  work();
  return cpu_ns() - start;
}

class Bench {
 public:
  explicit Bench(Size size)
      : stream_(make_stream(size)),
        cells_(BinCounters::cells_needed(stream_.width_px, stream_.height_px)),
        more_cells_(cells_.size()),
        surface_(cells_.size()) {}

  /// Nanoseconds of one run of a stage; what it takes to clear the memory is left out.
  double once(std::string_view stage) {
    if (stage == "floor") return timed([&] { measured_floor(stream_, surface_); });
    const Run& first = stream_.runs.front();
    if (stage == "counters") {
      BinCounters counters(stream_.width_px, stream_.height_px, cells_);
      counters.advance_to(first.bin);
      return timed([&] { measured_counters(stream_, counters); });
    }
    AnchoredMap map(ReliabilityConfig{}, stream_.width_px, stream_.height_px,
                    {{cells_, more_cells_}});
    for (BinNumber bin = first.bin - 16; bin < first.bin; ++bin) {  // both grids in turn
      map.begin_bin(bin, {}, std::numeric_limits<double>::infinity());
      for (const AnchorTarget& target : map.targets()) map.add(target, {}, bin);
    }
    // Turning by 0.05 and 2 rad/s before a lens of 200 px.
    const double speed_pxps = stage == "anchored_slow" ? 10.0 : 400.0;
    return timed([&] { measured_anchored(stream_, map, speed_pxps); });
  }

  /// Nanoseconds per event, the best of several runs.
  double ns(std::string_view stage) {
    double best = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 7; ++i) best = std::min(best, once(stage));
    return best / static_cast<double>(kEvents);
  }

 private:
  Stream stream_;
  std::vector<BinCell> cells_;
  std::vector<BinCell> more_cells_;
  std::vector<std::uint16_t> surface_;
};

constexpr std::string_view kStages[] = {"floor", "counters", "anchored_slow", "anchored_fast"};

}  // namespace

int main(int argc, char** argv) {
  if (argc == 1) {
    std::printf("ns per event at 1 Mev/s, processor time\n%-12s", "");
    for (const std::string_view stage : kStages)
      std::printf(" %14.*s", static_cast<int>(stage.size()), stage.data());
    std::printf("\n");
    for (const Size size : kSizes) {
      Bench bench(size);
      std::printf("%5dx%-6d", size.width_px, size.height_px);
      for (const std::string_view stage : kStages) std::printf(" %14.1f", bench.ns(stage));
      std::printf("\n");
    }
    return 0;
  }
  const std::string_view stage = argv[1];
  Size size = kSizes[0];
  const bool known = std::find(std::begin(kStages), std::end(kStages), stage) != std::end(kStages);
  if (!known || (argc > 2 && std::sscanf(argv[2], "%dx%d", &size.width_px, &size.height_px) != 2) ||
      size.width_px < 1 || size.width_px > 4096 || size.height_px < 1 || size.height_px > 4096) {
    std::fprintf(stderr, "usage: bench_reliability [STAGE [WIDTHxHEIGHT]]\n");
    return 2;
  }
  Bench(size).once(stage);
  std::printf("%zu events\n", kEvents);
  return 0;
}
