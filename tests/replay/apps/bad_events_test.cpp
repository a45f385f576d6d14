// What an event camera can send and no scene makes: counted, told, survived in bounded time and
// memory, and without harm to what frames and IMU know.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "drivers/replay/recording.hpp"
#include "pled_vins/sim/evt3_encoder.hpp"
#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;
using nlohmann::json;
using pled::Event;
using pled::Polarity;
using pled::sim::Evt3Encoder;

constexpr int kWidth = 240, kHeight = 180;
constexpr std::size_t kFrames = 50;          // 2.5 s at 20 Hz
constexpr std::int64_t kEnd_us = 2'450'000;  // the last of them
constexpr double kLargestAte_m = 0.05;
constexpr const char* kTrajectory = "trajectory.tum";

/// Replays and returns the report. The run must end well, and events add up. Frames are allowed so
/// few points that those of events take part in the solve.
json report_of(const RecordingCopy& recording, const std::vector<std::string>& more = {}) {
  recording.write("settings.yaml", "frontend:\n  max_points: 40\n");
  const Outcome o = recording.replay(more);
  REQUIRE_MESSAGE(o.code == 0, o.err);
  const json report = json::parse(recording.report());
  const json& events = report["events"];
  CHECK(events["in"] ==
        events["used"].get<std::uint64_t>() + events["dropped"].get<std::uint64_t>());
  return report;
}

std::uint64_t fault(const json& report, const char* kind) {
  return report["faults"].contains(kind) ? report["faults"][kind].get<std::uint64_t>() : 0;
}

/// The flight that every case spoils in its own way.
const std::vector<Event>& clean_events() {
  static const std::vector<Event> events = [] {
    const RecordingCopy recording;
    pled::replay::Problems problems;
    auto opened = pled::replay::Recording::open(recording.path().string(), problems);
    REQUIRE(opened.ok());
    auto replay = opened.value().open_events(problems);
    REQUIRE(replay.ok());
    REQUIRE(replay.value().source->start().ok());
    std::vector<Event> all, batch(4096);
    for (;;) {
      const auto chunk = replay.value().source->acquire({});
      if (!chunk.ok()) break;
      for (auto bytes = chunk.value().bytes; !bytes.empty();) {
        const auto step = replay.value().decoder->decode(bytes, batch);
        all.insert(all.end(), batch.begin(),
                   batch.begin() + static_cast<std::ptrdiff_t>(step.events));
        bytes = bytes.subspan(step.bytes_consumed);
      }
      replay.value().source->release();
    }
    return all;
  }();
  return events;
}

/// The clean run's report.
const json& clean_report() {
  static const json report = report_of(RecordingCopy{});
  return report;
}

/// The clean events with others among them, in the order of time.
std::vector<Event> with(std::vector<Event> more) {
  std::stable_sort(more.begin(), more.end(),
                   [](const Event& a, const Event& b) { return a.t < b.t; });
  std::vector<Event> all(clean_events().size() + more.size());
  std::merge(clean_events().begin(), clean_events().end(), more.begin(), more.end(), all.begin(),
             [](const Event& a, const Event& b) { return a.t < b.t; });
  return all;
}

void set_events(const RecordingCopy& recording, const std::vector<Event>& events) {
  std::vector<std::byte> words;
  Evt3Encoder(kWidth).encode(events, words);
  std::string file = Evt3Encoder::raw_header(kWidth, kHeight);
  file.append(reinterpret_cast<const char*>(words.data()), words.size());
  recording.write("events.raw", file);
}

std::string event_line(double t_s, const Event& e) {
  char line[64];
  std::snprintf(line, sizeof line, "%.6f %d %d %d\n", t_s, e.x_px, e.y_px,
                e.polarity == Polarity::kOn ? 1 : 0);
  return line;
}

double seconds(const Event& e) { return static_cast<double>(e.t.us) * 1e-6; }

/// The trajectory is still there, from about when it began without the fault, to the end.
void check_survived(const RecordingCopy& recording, const json& report) {
  CHECK(report["resets"] == 0);
  CHECK(report["frames"] == json{{"in", kFrames}, {"used", kFrames}, {"dropped", 0}});
  REQUIRE(report["accuracy"]["ate_rmse_m"].is_number());
  MESSAGE("ATE " << report["accuracy"]["ate_rmse_m"] << " m, clean "
                 << clean_report()["accuracy"]["ate_rmse_m"] << " m; stage events at most "
                 << report["stages"]["events"]["max_us"] << " us, clean "
                 << clean_report()["stages"]["events"]["max_us"] << " us");
  CHECK(report["accuracy"]["ate_rmse_m"] < kLargestAte_m);
  CHECK(report["initialised_at_s"].get<double>() <
        clean_report()["initialised_at_s"].get<double>() + 0.5);
  const std::vector<TumPose> poses = read_tum(recording.out() / kTrajectory);
  REQUIRE(!poses.empty());
  CHECK(poses.back().t_s == doctest::Approx(2.45));
}

/// Memory is what it is without the fault: nothing is kept for events that are too many.
void check_memory(const json& report) {
  constexpr double kSlack_bytes = 4e6;
  CHECK(report["memory"]["static_bytes"] == clean_report()["memory"]["static_bytes"]);
  CHECK(report["memory"]["peak_rss_bytes"].get<double>() <
        clean_report()["memory"]["peak_rss_bytes"].get<double>() + kSlack_bytes);
}

TEST_SUITE("apps.replay_bad_events") {
  TEST_CASE("a burst of 100 Mev/s is shed to the event and the trajectory goes on") {
    constexpr std::int64_t kBurst_us = 100'000;  // two frames
    std::mt19937_64 random(7);
    std::vector<Event> burst;
    burst.reserve(100 * kBurst_us);
    for (std::int64_t t = 1'200'000; t < 1'200'000 + kBurst_us; ++t)
      for (int row = 0; row < 4; ++row) {
        const auto x = static_cast<std::uint16_t>(random() % (kWidth - 25));
        const auto y = static_cast<std::uint16_t>(random() % kHeight);
        const Polarity p = random() % 2 == 0 ? Polarity::kOn : Polarity::kOff;
        for (std::uint16_t k = 0; k < 25; ++k)
          burst.push_back({{t}, static_cast<std::uint16_t>(x + k), y, p});
      }
    const RecordingCopy recording;
    const std::vector<Event> all = with(std::move(burst));
    set_events(recording, all);
    // 20 Mev/s: of each 1.024 ms the first 20 000.
    std::map<std::int64_t, std::uint64_t> slots;
    std::uint64_t played = 0;
    for (const Event& e : all) {
      if (e.t.us > kEnd_us) break;
      ++slots[e.t.us >> 10];
      ++played;
    }
    std::uint64_t shed = 0;
    for (const auto& [slot, n] : slots) shed += n - std::min<std::uint64_t>(n, 20'000);
    REQUIRE(shed > 7'000'000);
    const json report = report_of(recording);
    CHECK(report["events"]["in"] == played);
    CHECK(fault(report, "event_shed") == shed);
    CHECK(report["events"]["dropped"] == shed + fault(report, "event_hot_pixel"));
    // That bounds the work, whatever the machine: 5 M events came for each of two frames, and as
    // many were handed on as slots that a frame touches have room for.
    const json& clean = clean_report();
    const std::uint64_t handed_on = report["events"]["in"].get<std::uint64_t>() - shed;
    const std::uint64_t clean_ones = clean["events"]["in"].get<std::uint64_t>();
    CHECK(handed_on - clean_ones <= 2 * (50'000 / 1024 + 2) * 20'000);
    check_survived(recording, report);
    check_memory(report);
  }

  TEST_CASE("hot pixels are counted and told, and follow nothing") {
    constexpr double kRate_hz = 5000.0;
    constexpr int kPixels = 60;
    std::mt19937_64 random(5);
    std::vector<Event> hot;
    for (int k = 0; k < kPixels; ++k) {
      const auto x = static_cast<std::uint16_t>(random() % kWidth);
      const auto y = static_cast<std::uint16_t>(random() % kHeight);
      for (double t_us = static_cast<double>(random() % 200); t_us < kEnd_us;
           t_us += 1e6 / kRate_hz)
        hot.push_back({{static_cast<std::int64_t>(t_us)},
                       x,
                       y,
                       random() % 2 == 0 ? Polarity::kOn : Polarity::kOff});
    }
    const std::size_t sent = hot.size();
    const RecordingCopy recording;
    set_events(recording, with(std::move(hot)));
    const json report = report_of(recording);
    const std::uint64_t clean = fault(clean_report(), "event_hot_pixel");
    const std::uint64_t counted = fault(report, "event_hot_pixel") - clean;
    // A pixel above the limit is heard for some twenty events, until its tank is full.
    MESSAGE(counted << " of " << sent << " events of hot pixels were left out");
    CHECK(counted <= sent + 1000);  // and the scene's own at these pixels
    CHECK(counted >= sent - kPixels * 30);
    check_survived(recording, report);
    check_memory(report);
  }

  TEST_CASE("lamps that flicker at full contrast, below and above the hot limit, cost no pose") {
    for (const int steps : {4, 12}) {  // events a half period: 800 and 2400 a second of each pixel
      CAPTURE(steps);
      std::vector<Event> lamps;
      for (const auto& [x0, y0] : {std::pair{30, 30}, std::pair{150, 60}, std::pair{90, 120}})
        for (std::int64_t half_us = 0; half_us < kEnd_us; half_us += 5000)
          for (int step = 0; step < steps; ++step)
            for (int i = 0; i < 20 * 20; ++i)
              lamps.push_back({{half_us + 4000 * step / steps + i},
                               static_cast<std::uint16_t>(x0 + i % 20),
                               static_cast<std::uint16_t>(y0 + i / 20),
                               half_us / 5000 % 2 == 0 ? Polarity::kOn : Polarity::kOff});
      const std::size_t sent = lamps.size();
      const RecordingCopy recording;
      set_events(recording, with(std::move(lamps)));
      const json report = report_of(recording);
      MESSAGE(fault(report, "event_hot_pixel") << " of " << sent << " events were left out");
      CHECK((fault(report, "event_hot_pixel") > sent / 2) == (steps == 12));
      check_survived(recording, report);
      check_memory(report);
    }
  }

  TEST_CASE("an event camera that sends nothing is told, and the frames do as if alone") {
    const RecordingCopy recording;
    recording.write("settings.yaml", "frontend:\n  max_points: 40\n");
    REQUIRE(recording.replay({"--no-events"}).code == 0);
    const std::string alone = bytes_of(recording.out() / kTrajectory);
    REQUIRE(alone != "");
    recording.write("events.raw", Evt3Encoder::raw_header(kWidth, kHeight));
    const Outcome o = recording.replay();
    REQUIRE_MESSAGE(o.code == 0, o.err);
    CHECK_MESSAGE(contains(o.err, "gave not one event"), o.err);
    const json report = json::parse(recording.report());
    CHECK(report["events"] == json{{"in", 0}, {"used", 0}, {"dropped", 0}});
    CHECK(fault(report, "frame_without_events") == kFrames);
    CHECK((bytes_of(recording.out() / kTrajectory) == alone));
    // By nothing at all it sees nothing, and says so.
    const Outcome blind = recording.replay({"--no-frames"});
    CHECK(blind.code == 0);
    CHECK_MESSAGE(contains(blind.err, "never started: "), blind.err);
    CHECK(lines_of(recording.out() / kTrajectory).empty());

    recording.remove("events.raw");
    recording.write("events.txt", "");
    const Outcome empty = recording.replay();
    REQUIRE_MESSAGE(empty.code == 0, empty.err);
    CHECK_MESSAGE(contains(empty.err, "events.txt: the file is empty"), empty.err);
    CHECK((bytes_of(recording.out() / kTrajectory) == alone));
  }

  TEST_CASE("stamps that go back are held and counted, and no event is lost for them") {
    const RecordingCopy recording;
    recording.remove("events.raw");
    std::string text;
    std::uint64_t held = 0, played = 0, n = 0;
    for (const Event& e : clean_events()) {
      // A block that is sent 0.2 s late, and now and then one line from before the beginning.
      const bool late = e.t.us > 1'200'000 && e.t.us < 1'210'000;
      const bool lone = ++n % 5000 == 0;
      text += event_line(lone ? -1.0 : seconds(e) - (late ? 0.2 : 0.0), e);
      if (e.t.us > kEnd_us) continue;
      ++played;
      held += late || lone ? 1U : 0U;
    }
    recording.write("events.txt", text);
    const json report = report_of(recording);
    REQUIRE(held > 100);
    // Only those between the last frame and the end of a batch may be missing or more.
    CHECK(fault(report, "event_time_backwards") >= held);
    CHECK(fault(report, "event_time_backwards") <= held + 10);
    CHECK(report["events"]["in"].get<double>() == doctest::Approx(static_cast<double>(played)));
    check_survived(recording, report);
  }

  TEST_CASE("one stamp far ahead costs its event and not those that follow") {
    const RecordingCopy recording;
    recording.remove("events.raw");
    std::string text;
    std::uint64_t played = 0, n = 0;
    for (const Event& e : clean_events()) {
      text += event_line(++n == 20'000 ? 9000.0 : seconds(e), e);
      played += e.t.us <= kEnd_us ? 1U : 0U;
    }
    REQUIRE(n > 40'000);
    recording.write("events.txt", text);
    const json report = report_of(recording);
    CHECK(report["faults"] == json{{"event_malformed", 1}});
    CHECK(report["events"]["in"] == played - 1);
    check_survived(recording, report);
  }

  TEST_CASE("a flight across 2^32 microseconds is the flight, feature for feature") {
    // Whole periods of everything that is counted in powers of two, so that bins and slots fall
    // alike.
    constexpr double kPeriod_s = 1.048576;  // 2^20 us
    const auto moved_by = [](double offset_s, std::vector<std::string> more) {
      const RecordingCopy recording;
      for (const char* file : {"images.txt", "imu.txt", "groundtruth.txt"}) {
        std::vector<std::string> lines = recording.lines(file);
        for (std::string& line : lines) {
          if (line.empty() || line[0] == '#') continue;
          char stamp[40];
          std::snprintf(stamp, sizeof stamp, "%.9f", std::stod(line) + offset_s);
          line.replace(0, line.find(' '), stamp);
        }
        recording.set_lines(file, lines);
      }
      recording.remove("events.raw");
      std::string text;
      for (const Event& e : clean_events()) text += event_line(seconds(e) + offset_s, e);
      recording.write("events.txt", text);
      const json report = report_of(recording, more);
      json faults = report["faults"];
      faults.erase("event_without_turn");  // those before the first inertial sample: no map of them
      faults.erase("event_map_outside");   // the camera turns
      CHECK_MESSAGE(faults.empty(), faults.dump());
      std::vector<std::string> rows;  // without their stamps
      for (const char* file : {kTrajectory, "features.csv"})
        for (const std::string& line : lines_of(recording.out() / file))
          rows.push_back(line.substr(line.find_first_of(" ,")));
      return rows;
    };
    // 2^32 us lie 1.048576 s into the flight.
    for (const std::string score : {"motion", "paper"}) {
      CAPTURE(score);
      const auto across = moved_by(4095 * kPeriod_s, {"--score", score});
      const auto before = moved_by(16 * kPeriod_s, {"--score", score});
      CHECK(across.size() > 1000);
      CHECK(across == before);
    }
  }
}

}  // namespace
