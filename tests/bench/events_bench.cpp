// What the event front end costs at four sensor sizes, for one stream of events each: instructions
// under callgrind (scripts/count_instructions.sh), nanoseconds when run by itself.
//
// Each stage is one function that no compiler inlines, so that callgrind finds it by its name. A
// new stage is a function and a row of kStages.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "pled_vins/events/active_surface.hpp"
#include "pled_vins/events/arc_star.hpp"
#include "pled_vins/events/brightness_surface.hpp"
#include "pled_vins/events/event_warp.hpp"
#include "pled_vins/events/time_surface.hpp"
#include "pled_vins/events/turn_history.hpp"
#include "pled_vins/reliability/bin_clock.hpp"
#include "pled_vins/reliability/bin_counters.hpp"
#include "pled_vins/reliability/config.hpp"
#include "support/events/edge_stream.hpp"

namespace {

using namespace pled;

constexpr std::size_t kEvents = 400'000;
constexpr std::int64_t kFrame_us = 33'333;
constexpr int kRepeats = 9;
constexpr std::size_t kRun = 512;  // events that the map takes at once
constexpr int kMargin = limits::kMapMargin_px;

CameraCalibration camera_of(int width_px, int height_px) {
  CameraCalibration c;
  c.width_px = width_px;
  c.height_px = height_px;
  c.fx_px = c.fy_px = 0.8 * width_px;
  c.cx_px = 0.5 * (width_px - 1);
  c.cy_px = 0.5 * (height_px - 1);
  c.distortion = Distortion::kRadtan;
  c.coeffs = {-0.1, 0.01, 0.0, 0.0, 0.0};
  return c;
}

/// Events of one bin, cut as EventScores does.
struct Run {
  BinNumber bin = 0;
  std::size_t first = 0;
  std::size_t count = 0;
};

/// The whole front end at one sensor size, and the events of the frame in hand.
struct Bench {
  Bench(int width_px, int height_px)
      : camera(camera_of(width_px, height_px)),
        pixels(UndistortionTable::floats_needed(width_px, height_px) / 2),
        floor_us(2 * pixels.size()),
        surface(EventConfig{}, width_px, height_px, pixels),
        verdicts(kEvents),
        brightness_pixels(pixels.size()),
        brightness(EventConfig{}.brightness_decay_ms, width_px, height_px, brightness_pixels),
        bearings(UndistortionTable::floats_needed(width_px, height_px)),
        warped(kEvents),
        cells(BinCounters::cells_needed(width_px + 2 * kMargin, height_px + 2 * kMargin)),
        counters(width_px + 2 * kMargin, height_px + 2 * kMargin, cells),
        time_surface(EventConfig{}.surface_decay_ms),
        scratch(TimeSurface::floats_needed(width_px, height_px)),
        grey(pixels.size()),
        arc_star(EventConfig{}) {
    if (!table.build(Camera(camera), bearings) || !warp.build(table, rectified(camera)) ||
        !map_warp.build(table, rectified(camera, kMargin)))
      std::abort();
  }

  [[nodiscard]] ImageView<std::uint8_t> picture() {
    return {grey.data(), camera.width_px, camera.height_px, camera.width_px};
  }

  /// The gyro up to t: a turn of 1 rad/s about a slanted axis.
  void turn_until(std::int64_t t_us) {
    for (std::int64_t t = t_us - kFrame_us; t <= t_us; t += 1000) {
      const ImuSample sample{{t}, {0.6, 0.7, 0.4}, {}};
      turn.extend({&sample, 1}, Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity());
    }
    const ImuSample last{{t_us}, {0.6, 0.7, 0.4}, {}};
    turn.extend({&last, 1}, Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity());
  }

  void cut_into_runs() {
    runs.clear();
    for (std::size_t i = 0; i < events.size();) {
      const TimeBin bin = clock.bin_of(events[i].t);
      std::size_t end = i + 1;
      const std::int64_t knot_end_us = events[i].t.us | (TurnHistory::kKnot_us - 1);
      const Timestamp last = std::min(bin.end, Timestamp{knot_end_us});
      while (end < std::min(events.size(), i + kRun) && events[end].t <= last) ++end;
      runs.push_back({bin.number, i, end - i});
      i = end;
    }
  }

  CameraCalibration camera;
  std::vector<SurfacePixel> pixels;
  std::vector<std::int64_t> floor_us;
  ActiveSurface surface;
  std::vector<EventVerdict> verdicts;
  std::vector<BrightnessPixel> brightness_pixels;
  BrightnessSurface brightness;
  std::vector<float> bearings;
  UndistortionTable table;
  EventWarp warp;
  EventWarp map_warp;
  TurnHistory turn;
  TurnSlices slices;
  std::vector<WarpedPixel> warped;
  std::vector<BinCell> cells;
  BinCounters counters;
  BinClock clock{Duration{ReliabilityConfig{}.bin_us}};
  std::vector<Run> runs;
  TimeSurface time_surface;
  std::vector<float> scratch;
  std::vector<std::uint8_t> grey;
  ArcStarDetector arc_star;
  FixedVector<EventCorner, limits::kMaxPoints> corners;

  std::span<const Event> events;
  Timestamp t_frame;
  Timestamp t_reference;  ///< of the map
  std::size_t sink = 0;
};

#define PLED_STAGE extern "C" __attribute__((noinline)) void

/// The least that a surface can cost: one store for each event.
PLED_STAGE stage_floor(Bench& b) {
  const auto width = static_cast<std::size_t>(b.camera.width_px);
  std::int64_t* stamps = b.floor_us.data();
  for (const Event& e : b.events)
    stamps[2 * (e.y_px * width + e.x_px) + static_cast<std::size_t>(e.polarity)] = e.t.us;
}

PLED_STAGE stage_surface(Bench& b) { b.surface.insert(b.events, b.verdicts); }

/// The slices of each run and its events through them, to one instant, as the map has it.
PLED_STAGE stage_compensation(Bench& b) {
  for (const Run& run : b.runs) {
    const std::span<const Event> events = b.events.subspan(run.first, run.count);
    if (!b.turn.slices(b.t_reference, events.front().t, events.back().t,
                       b.map_warp.slice_error_rad(), b.slices))
      std::abort();
    b.map_warp.warp(events, b.slices, std::span(b.warped).subspan(run.first, run.count));
  }
}

PLED_STAGE stage_counters(Bench& b) {
  for (const Run& run : b.runs)
    b.counters.add(std::span(b.warped).subspan(run.first, run.count), run.bin);
}

PLED_STAGE stage_brightness(Bench& b) { b.brightness.insert(b.events, b.verdicts); }

PLED_STAGE stage_brightness_picture(Bench& b) {
  if (!b.brightness.render(b.t_frame, b.picture())) std::abort();
}

PLED_STAGE stage_arc_star(Bench& b) {
  b.arc_star.detect(b.surface, b.t_frame, {}, limits::kMaxPoints, b.corners);
  b.sink += b.corners.size();
}

PLED_STAGE stage_time_surface_raw(Bench& b) {
  b.time_surface.render(b.surface, b.t_frame, SurfaceTone::kSigned, b.picture());
}

PLED_STAGE stage_time_surface_carried(Bench& b) {
  const Timestamp from =
      std::max(*b.turn.oldest(), b.t_frame - b.time_surface.reach(Meeting::kBlended));
  if (!b.turn.slices(b.t_frame, from, b.t_frame, b.warp.slice_error_rad(), b.slices)) std::abort();
  b.time_surface.render(b.surface, b.warp, b.slices, SurfaceTone::kSigned, Meeting::kBlended,
                        b.scratch, b.picture());
}

struct Stage {
  const char* name;
  void (*run)(Bench&);
  bool per_event;  ///< else once a frame, whatever the events
};

constexpr std::array kStages{
    Stage{"floor", stage_floor, true},
    Stage{"surface", stage_surface, true},
    Stage{"compensation", stage_compensation, true},
    Stage{"counters", stage_counters, true},
    Stage{"brightness", stage_brightness, true},
    Stage{"brightness_picture", stage_brightness_picture, false},
    Stage{"arc_star", stage_arc_star, false},
    Stage{"time_surface_raw", stage_time_surface_raw, false},
    Stage{"time_surface_carried", stage_time_surface_carried, false},
};

/// Processor time of this thread, so that other programs do not count.
double cpu_ns() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e9 + static_cast<double>(now.tv_nsec);
}

/// Nanoseconds of each stage over the whole stream; `frames` and corners are counted.
std::array<double, kStages.size()> play(Bench& b, std::span<const Event> stream,
                                        std::size_t& frames) {
  std::array<double, kStages.size()> spent_ns{};
  frames = 0;
  b.surface.clear();
  b.brightness.clear();
  b.turn.clear();
  b.counters.clear();
  b.counters.advance_to(b.clock.bin_of(stream.front().t).number);  // clears its memory
  b.t_frame = b.t_reference = stream.front().t;
  b.turn_until(b.t_frame.us);
  while (!stream.empty()) {
    b.t_frame.us += kFrame_us;
    b.turn_until(b.t_frame.us);
    std::size_t n = 0;
    while (n < stream.size() && stream[n].t <= b.t_frame) ++n;
    b.events = stream.first(n);
    stream = stream.subspan(n);
    b.cut_into_runs();
    ++frames;
    for (std::size_t k = 0; k < kStages.size(); ++k) {
      const double start = cpu_ns();
      kStages[k].run(b);
      spent_ns[k] += cpu_ns() - start;
    }
  }
  return spent_ns;
}

void measure(int width_px, int height_px, int repeats) {
  support::EdgeStreamOptions options;
  options.width_px = width_px;
  options.height_px = height_px;
  options.events = kEvents;
  const std::vector<Event> stream = support::edge_stream(options);
  const auto bench = std::make_unique<Bench>(width_px, height_px);
  std::array<double, kStages.size()> best_ns{};
  best_ns.fill(std::numeric_limits<double>::infinity());
  std::size_t frames = 0;
  for (int r = 0; r < repeats; ++r) {
    const auto spent_ns = play(*bench, stream, frames);
    for (std::size_t k = 0; k < kStages.size(); ++k) best_ns[k] = std::min(best_ns[k], spent_ns[k]);
  }
  const SurfaceCounts counts = bench->surface.counts();
  std::printf("%dx%d: %zu events, %zu frames, accepted %.3f, hot %.4f, corners a frame %.1f\n",
              width_px, height_px, kEvents, frames,
              static_cast<double>(counts.accepted) / static_cast<double>(counts.in),
              static_cast<double>(counts.hot) / static_cast<double>(counts.in),
              static_cast<double>(bench->sink) / static_cast<double>(frames) / repeats);
  for (std::size_t k = 0; k < kStages.size(); ++k) {
    std::printf("  %-22s %8.2f ns/event", kStages[k].name,
                best_ns[k] / static_cast<double>(kEvents));
    if (!kStages[k].per_event)
      std::printf("  %8.1f us/frame", best_ns[k] * 1e-3 / static_cast<double>(frames));
    std::printf("\n");
  }
}

}  // namespace

/// events_bench [WIDTH HEIGHT]: all four sizes, best of 9; or one size once, for callgrind.
int main(int argc, char** argv) {
  if (argc == 3) {
    measure(std::atoi(argv[1]), std::atoi(argv[2]), 1);
    return 0;
  }
  for (const auto& size : {limits::kDavis240, limits::kDavis346, limits::kVga, limits::kHd})
    measure(size.width_px, size.height_px, kRepeats);
  return 0;
}
