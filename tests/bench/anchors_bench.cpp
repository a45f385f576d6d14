// What it costs, and what it changes, that events go to anchors as they come instead of being
// warped anew for each frame. A camera that turns before edges, see support::RotatingEdges.
//
// bench_anchors: nanoseconds, and differences of the scores, at four rates of turning.
// bench_anchors RATE: that rate (rad/s) once, for callgrind, which finds the stage_* functions.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pled_vins/pipeline/event_scores.hpp"
#include "support/reliability/rotating_edges.hpp"

namespace {

using namespace pled;
using support::RotatingEdges;

constexpr Duration kLength{300'000};
constexpr std::int64_t kStart_us = 1'000'000;
constexpr int kMargin = limits::kMapMargin_px;
constexpr Duration kBin{ReliabilityConfig{}.bin_us};
constexpr auto kBins = static_cast<std::int64_t>(limits::kTimeBins);
constexpr std::size_t kCells =
    BinCounters::cells_needed(RotatingEdges::kGridWidth_px, RotatingEdges::kGridHeight_px);

Eigen::Vector3d rate_of(double radps) { return {0.2 * radps, radps, 0.1 * radps}; }

CameraCalibration camera() {
  CameraCalibration c;
  c.width_px = RotatingEdges::kWidth_px;
  c.height_px = RotatingEdges::kHeight_px;
  c.fx_px = c.fy_px = RotatingEdges::kFocal_px;
  c.cx_px = 0.5 * (c.width_px - 1);
  c.cy_px = 0.5 * (c.height_px - 1);
  return c;
}

struct Bench {
  explicit Bench(const RotatingEdges& scene, const Eigen::Vector3d& rate_radps) {
    if (!table.build(Camera(camera()), bearings) ||
        !warp.build(table, rectified(camera(), kMargin)))
      std::abort();
    for (const support::TimedPixel& e : scene.events()) {
      const Timestamp t{kStart_us + e.t.us};
      events.push_back({t, static_cast<std::uint16_t>(e.at.x_px),
                        static_cast<std::uint16_t>(e.at.y_px), Polarity::kOn});
    }
    warped.resize(events.size());
    for (std::int64_t t = kStart_us - 50'000; t <= kStart_us + kLength.us; t += 1000) {
      const ImuSample sample{{t}, {rate_radps.x(), rate_radps.y(), rate_radps.z()}, {}};
      turn.extend({&sample, 1}, Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity());
    }
    scores.emplace(ReliabilityConfig{}, warp, rectified(camera(), kMargin),
                   AnchoredMapBuffers{{a, b}});
    counters.advance_to(0);
  }

  std::vector<float> bearings = std::vector<float>(
      UndistortionTable::floats_needed(RotatingEdges::kWidth_px, RotatingEdges::kHeight_px));
  UndistortionTable table;
  EventWarp warp;
  TurnHistory turn;
  std::vector<Event> events;

  std::vector<BinCell> a = std::vector<BinCell>(kCells);
  std::vector<BinCell> b = std::vector<BinCell>(kCells);
  std::optional<EventScores> scores;  ///< takes its size from the warp

  TurnSlices slices;
  std::vector<WarpedPixel> warped;
  std::vector<BinCell> c = std::vector<BinCell>(kCells);
  BinCounters counters{RotatingEdges::kGridWidth_px, RotatingEdges::kGridHeight_px, c};
  BinNumber next_bin = 0;
};

#define PLED_STAGE extern "C" __attribute__((noinline)) void

/// Events between two frames to the anchors.
PLED_STAGE stage_anchors(Bench& bench, std::span<const Event> events) {
  bench.scores->on_events(events, bench.turn);
}

/// The window's events to the orientation at the frame. Bins are numbered on, so that what the
/// frame before left in the grid has aged out.
inline void rewarp(Bench& bench, std::span<const Event> window, Timestamp t_frame) {
  if (window.empty()) return;
  if (!bench.turn.slices(t_frame, window.front().t, t_frame, bench.warp.slice_error_rad(),
                         bench.slices))
    std::abort();
  bench.warp.warp(window, bench.slices, bench.warped);
  bench.next_bin += 2 * kBins;
  for (std::size_t i = 0; i < window.size();) {
    const std::int64_t age = (t_frame - window[i].t).us / kBin.us;
    std::size_t end = i + 1;
    while (end < window.size() && (t_frame - window[end].t).us / kBin.us == age) ++end;
    bench.counters.add(std::span(bench.warped).subspan(i, end - i), bench.next_bin - age);
    i = end;
  }
}
PLED_STAGE stage_rewarp_at_30_hz(Bench& bench, std::span<const Event> window, Timestamp t_frame) {
  rewarp(bench, window, t_frame);
}
PLED_STAGE stage_rewarp_at_60_hz(Bench& bench, std::span<const Event> window, Timestamp t_frame) {
  rewarp(bench, window, t_frame);
}

/// Processor time of this thread, so that other programs do not count.
double cpu_ns() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e9 + static_cast<double>(now.tv_nsec);
}

struct Spent {
  double anchors_ns = 0.0;
  double rewarp_30_hz_ns = 0.0;
  double rewarp_60_hz_ns = 0.0;
};

Spent play(Bench& bench) {
  const std::span<const Event> all = bench.events;
  const auto until = [&](std::int64_t t_us) {
    return static_cast<std::size_t>(
        std::upper_bound(all.begin(), all.end(), Timestamp{t_us},
                         [](Timestamp t, const Event& e) { return t < e.t; }) -
        all.begin());
  };
  const auto timed = [](const auto& work) {
    const double start = cpu_ns();
    work();
    return cpu_ns() - start;
  };
  Spent spent;
  std::size_t done = 0;
  for (int sixtieth = 1; sixtieth <= 18; ++sixtieth) {
    const Timestamp t{kStart_us + sixtieth * 1'000'000LL / 60};
    const std::size_t begin = until(t.us - kBins * kBin.us);
    const std::span<const Event> window = all.subspan(begin, until(t.us) - begin);
    spent.rewarp_60_hz_ns += timed([&] { stage_rewarp_at_60_hz(bench, window, t); });
    if (sixtieth % 2 != 0) continue;
    spent.rewarp_30_hz_ns += timed([&] { stage_rewarp_at_30_hz(bench, window, t); });
    bench.scores->expect(t);
    const std::span<const Event> since = all.subspan(done, until(t.us) - done);
    spent.anchors_ns += timed([&] { stage_anchors(bench, since); });
    bench.scores->observe(t);
    done += since.size();
  }
  return spent;
}

void measure(double radps) {
  const RotatingEdges scene(rate_of(radps), kLength, 1);
  Spent best{1e30, 1e30, 1e30};
  for (int i = 0; i < 7; ++i) {
    const auto bench = std::make_unique<Bench>(scene, rate_of(radps));
    const Spent spent = play(*bench);
    best.anchors_ns = std::min(best.anchors_ns, spent.anchors_ns);
    best.rewarp_30_hz_ns = std::min(best.rewarp_30_hz_ns, spent.rewarp_30_hz_ns);
    best.rewarp_60_hz_ns = std::min(best.rewarp_60_hz_ns, spent.rewarp_60_hz_ns);
  }
  const auto n = static_cast<double>(scene.events().size());
  const support::RewarpComparison c = support::compare_with_rewarp(scene, kLength, 33'333);
  std::printf("%8.2f %8.0f %8.1f %8.1f %8.1f %9.3f %9.3f %9.3f %9.3f\n", radps, n,
              best.anchors_ns / n, best.rewarp_30_hz_ns / n, best.rewarp_60_hz_ns / n,
              c.anchored.mean, c.half_pixel.mean, c.anchored_pooled.mean, c.half_pixel_pooled.mean);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2) {
    const Eigen::Vector3d rate_radps = rate_of(std::atof(argv[1]));
    const auto bench = std::make_unique<Bench>(RotatingEdges(rate_radps, kLength, 1), rate_radps);
    (void)play(*bench);
    std::printf("%zu events\n", bench->events.size());
    return 0;
  }
  std::printf("%8s %8s %26s %19s %19s\n", "", "", "ns/event", "|ds| at a pixel", "of 3 x 3");
  std::printf("%8s %8s %8s %8s %8s %9s %9s %9s %9s\n", "rad/s", "events", "anchors", "at 30 Hz",
              "at 60 Hz", "anchors", "0.49 px", "anchors", "0.49 px");
  for (const double radps : {0.0, 0.1, 0.5, 2.0}) measure(radps);
  return 0;
}
