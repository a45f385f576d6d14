// Faults inside a recording: counted, told, and survived. Nothing is lost before the fault.

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "pled_vins/core/image_view.hpp"
#include "src/sim/png_file.hpp"
#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;
using nlohmann::json;

constexpr std::size_t kFrames = 50;     // 2.5 s at 20 Hz
constexpr double kLargestAte_m = 0.05;  // of a run that lost a little
constexpr const char* kTrajectory = "trajectory.tum";

/// Replays and returns the report. The run must end well.
json report_of(const RecordingCopy& recording, const std::vector<std::string>& more = {}) {
  const Outcome o = recording.replay(more);
  REQUIRE_MESSAGE(o.code == 0, o.err);
  return json::parse(recording.report());
}

/// The lines of a trajectory before a time.
std::vector<std::string> before(const RecordingCopy& recording, double t_s) {
  std::vector<std::string> lines;
  for (const std::string& line : lines_of(recording.out() / kTrajectory))
    if (std::stod(line) < t_s) lines.push_back(line);
  return lines;
}

/// A recording as it was made, replayed once.
const RecordingCopy& undisturbed() {
  static const RecordingCopy* recording = [] {
    static const RecordingCopy copy;
    REQUIRE(copy.replay().code == 0);
    return &copy;
  }();
  return *recording;
}

/// The lines that an undisturbed run writes before a time.
std::vector<std::string> undisturbed_before(double t_s) { return before(undisturbed(), t_s); }

/// Adds to the stamps of up to `count` lines, from the first that is stamped at or after `from_s`.
void shift_stamps(const RecordingCopy& recording, const std::string& file, double from_s,
                  double shift_s, std::size_t count) {
  std::vector<std::string> lines = recording.lines(file);
  for (std::string& line : lines) {
    if (line.empty() || line[0] == '#' || count == 0 || std::stod(line) < from_s) continue;
    char stamp[40];
    std::snprintf(stamp, sizeof stamp, "%.9f", std::stod(line) + shift_s);
    line.replace(0, line.find(' '), stamp);
    --count;
  }
  recording.set_lines(file, lines);
}

/// Rows of event points in features.csv that are stamped at or after a time, by a clock that was
/// set by `leap_s`.
std::size_t event_points_after(const RecordingCopy& recording, double leap_s, double t_s) {
  std::size_t n = 0;
  for (const std::string& line : lines_of(recording.out() / "features.csv")) {
    const std::vector<std::string> fields = csv_fields(line);
    const bool is_event = fields[2] == "event_point";
    const double since_s = is_event ? std::stod(fields[0]) - leap_s - t_s : -1.0;
    if (since_s > -1e-6 && since_s < 10.0) ++n;
  }
  return n;
}

TEST_SUITE("apps.replay_bad_data") {
  TEST_CASE("a few stamps far ahead or far back lose those samples and nothing else") {
    for (const double leap_s : {1000.0, -1000.0}) {
      CAPTURE(leap_s);
      const RecordingCopy recording;
      recording.remove("events.raw");  // their clock would stay behind
      // Back beyond zero no clock reaches: all times are moved on first.
      for (const char* file : {"images.txt", "imu.txt", "groundtruth.txt"})
        shift_stamps(recording, file, -1e9, 2000.0, 1'000'000);
      shift_stamps(recording, "imu.txt", 2001.2, leap_s, 2);
      shift_stamps(recording, "images.txt", 2001.5, leap_s, 2);
      const json report = report_of(recording);
      // The line after a wild one that goes on from before it tells the list itself.
      CHECK(report["faults"] ==
            json{{"frame_out_of_order", 1}, {"frame_stamp_wild", 1}, {"imu_stamp_wild", 2}});
      CHECK(report["frames"] == json{{"in", kFrames}, {"used", kFrames - 2}, {"dropped", 2}});
      CHECK(report["imu"]["dropped"] == 2);
      CHECK(report["resets"] == 0);
      CHECK(report["accuracy"]["ate_rmse_m"] < kLargestAte_m);
      CHECK(read_tum(recording.out() / kTrajectory).back().t_s == doctest::Approx(2002.45));
    }
  }

  TEST_CASE("a clock that is set, forward or back, is followed after a few samples and told") {
    constexpr std::size_t kLines = 10'000'000;
    for (const double leap_s : {1000.0, -1000.0}) {
      // Inertial samples that jump a little before the last frame are met while it is played.
      for (const double imu_from_s : {2001.2, 2001.14}) {
        CAPTURE(leap_s);
        CAPTURE(imu_from_s);
        const RecordingCopy recording(RecordingCopy::Scene::kTextEvents);
        for (const auto& [file, from_s] :
             {std::pair{"images.txt", 2001.2}, {"imu.txt", imu_from_s}, {"events.txt", 2001.2}}) {
          shift_stamps(recording, file, -1e9, 2000.0, kLines);
          shift_stamps(recording, file, from_s, leap_s, kLines);
        }
        const json report = report_of(recording);
        CHECK(report["faults"]["clock_jump"] >= 1);
        CHECK(report["faults"]["frame_stamp_wild"] == 4);
        CHECK(report["resets"] >= 1);
        CHECK(read_tum(recording.out() / kTrajectory).back().t_s ==
              doctest::Approx(2002.45 + leap_s));
        // 63 events show that it was set back: they are held before it. Or the surface takes as
        // many for wild, when it has seen the last of the old clock.
        const char* fault = leap_s > 0.0 ? "event_stamp_wild" : "event_time_backwards";
        CHECK(report["faults"][fault] == 63);
        CHECK(
            !report["faults"].contains(leap_s > 0.0 ? "event_time_backwards" : "event_stamp_wild"));
        // 21 frames, of which the first can have no points yet.
        CHECK(event_points_after(recording, leap_s, 2001.4) > 20 * 5);
      }
    }
  }

  TEST_CASE("a truncated image in the middle is one frame lost and counted, the others are used") {
    const RecordingCopy recording;
    const std::string name = "images/frame_00000030.png";
    const std::string whole = bytes_of(recording.path() / name);
    recording.write(name, whole.substr(0, whole.size() / 2));
    const Outcome o = recording.replay();
    REQUIRE(o.code == 0);
    CHECK_MESSAGE(contains(o.err, "frame_00000030.png"), o.err);
    const json report = json::parse(recording.report());
    CHECK(report["faults"] == json{{"frame_unreadable", 1}});
    CHECK(report["frames"] == json{{"in", kFrames}, {"used", kFrames - 1}, {"dropped", 1}});
    CHECK(report["accuracy"]["ate_rmse_m"] < kLargestAte_m);
    CHECK(before(recording, 1.5) == undisturbed_before(1.5));
    bool has_lost_one = false;
    for (const TumPose& pose : read_tum(recording.out() / kTrajectory))
      has_lost_one = has_lost_one || pose.stamp == "1.500000000";
    CHECK(!has_lost_one);
  }

  TEST_CASE("a damaged first image only begins the run one frame later") {
    const RecordingCopy recording;
    recording.write("images/frame_00000000.png", "no image");
    const json report = report_of(recording);
    CHECK(report["faults"] == json{{"frame_unreadable", 1}});
    CHECK(report["frames"]["used"] == kFrames - 1);
    CHECK(report["accuracy"]["ate_rmse_m"] < kLargestAte_m);
  }

  TEST_CASE("an image of another size is lost and counted, and does not stop the run") {
    const RecordingCopy recording;
    recording.remove("images/frame_00000030.png");
    const std::vector<std::uint8_t> grey(320 * 240, 128);
    REQUIRE(pled::sim::write_png(recording.path() / "images/frame_00000030.png",
                                 {grey.data(), 320, 240, 320})
                .ok());
    const json report = report_of(recording);
    CHECK(report["faults"] == json{{"frame_unreadable", 1}});
    CHECK(report["frames"]["used"] == kFrames - 1);
  }

  TEST_CASE("NaN and text in imu.txt cost their lines only, and a line is named") {
    const RecordingCopy recording;
    std::vector<std::string> imu = recording.lines("imu.txt");
    imu[300] = "1.500000000 nan 0 9.81 0 0 0";
    imu[310] = "1.550000000 0 0 9.81 zero 0 0";
    imu[320] = "garbage";
    imu[330] = "1.650000000 0 0";
    recording.set_lines("imu.txt", imu);
    const Outcome o = recording.replay();
    REQUIRE(o.code == 0);
    CHECK_MESSAGE(contains(o.err, "imu.txt line 331"), o.err);  // the last of them
    const json report = json::parse(recording.report());
    CHECK(report["faults"] == json{{"imu_unreadable", 4}});
    CHECK(report["imu"]["dropped"] == 4);
    CHECK(report["imu"]["in"] ==
          report["imu"]["used"].get<int>() + report["imu"]["dropped"].get<int>());
    CHECK(report["frames"]["used"] == kFrames);
    CHECK(report["accuracy"]["ate_rmse_m"] < kLargestAte_m);
    CHECK(before(recording, 1.45) == undisturbed_before(1.45));
  }

  TEST_CASE("NaN, text and short lines in images.txt cost their frames only") {
    const RecordingCopy recording;
    std::vector<std::string> images = recording.lines("images.txt");
    images[30] = "nan images/frame_00000030.png";
    images[32] = "text";
    images[34] = "1.700000000";
    recording.set_lines("images.txt", images);
    const json report = report_of(recording);
    CHECK(report["faults"] == json{{"frame_unreadable", 3}});
    CHECK(report["frames"] == json{{"in", kFrames}, {"used", kFrames - 3}, {"dropped", 3}});
    CHECK(report["accuracy"]["ate_rmse_m"] < kLargestAte_m);
  }

  TEST_CASE("unsorted and repeated stamps in images.txt are skipped and counted") {
    const RecordingCopy recording;
    std::vector<std::string> images = recording.lines("images.txt");
    std::swap(images[30], images[31]);
    images.insert(images.begin() + 40, images[40]);
    recording.set_lines("images.txt", images);
    const json report = report_of(recording);
    CHECK(report["faults"] == json{{"frame_out_of_order", 2}});
    CHECK(report["frames"]["in"] == kFrames + 1);
    CHECK(report["frames"]["used"] == kFrames - 1);
    CHECK(report["frames"]["dropped"] == 2);
    CHECK(report["accuracy"]["ate_rmse_m"] < kLargestAte_m);
    double last_s = -1.0;
    for (const TumPose& pose : read_tum(recording.out() / kTrajectory)) {
      CHECK(pose.t_s > last_s);
      last_s = pose.t_s;
    }
  }

  TEST_CASE("unsorted and repeated stamps in imu.txt are dropped and counted") {
    const RecordingCopy recording;
    std::vector<std::string> imu = recording.lines("imu.txt");
    std::swap(imu[300], imu[301]);
    imu.insert(imu.begin() + 400, imu[400]);
    recording.set_lines("imu.txt", imu);
    const json report = report_of(recording);
    CHECK(report["faults"] == json{{"imu_backwards", 1}, {"imu_duplicate", 1}});
    CHECK(report["imu"]["dropped"] == 2);
    CHECK(report["frames"]["used"] == kFrames);
    CHECK(report["accuracy"]["ate_rmse_m"] < kLargestAte_m);
  }

  TEST_CASE("a gap of half a second in the inertial data is reported and the trajectory goes on") {
    const RecordingCopy recording;
    std::vector<std::string> imu = recording.lines("imu.txt");
    imu.erase(imu.begin() + 300, imu.begin() + 400);  // 1.5 ... 2.0 s
    recording.set_lines("imu.txt", imu);
    const json report = report_of(recording);
    CHECK(report["faults"]["imu_gap"] == 1);
    CHECK(report["resets"] == 1);
    CHECK(report["faults"]["estimator_reset"] == 1);
    CHECK(before(recording, 1.49) == undisturbed_before(1.49));
    const std::vector<TumPose> poses = read_tum(recording.out() / kTrajectory);
    REQUIRE(!poses.empty());
    CHECK(poses.back().stamp == "2.450000000");
    // 0.6 m/s across half a second: the frame of the output is kept, no jump home.
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const auto step = [&](std::size_t k) { return poses[i].p[k] - poses[i - 1].p[k]; };
      CAPTURE(poses[i].stamp);
      CHECK(std::hypot(step(0), step(1), step(2)) < 0.8);
    }
  }

  TEST_CASE("inertial data that end early end the trajectory there, with the frames counted") {
    const RecordingCopy recording;
    std::vector<std::string> imu = recording.lines("imu.txt");
    imu.resize(301);  // up to 1.5 s
    recording.set_lines("imu.txt", imu);
    const json report = report_of(recording);
    CHECK(report["faults"]["frame_without_imu"].get<int>() >= 17);
    CHECK(report["frames"]["dropped"] == report["faults"]["frame_without_imu"]);
    CHECK(before(recording, 1.49) == undisturbed_before(1.49));
    CHECK(read_tum(recording.out() / kTrajectory).back().t_s < 1.6);
  }

  TEST_CASE("frames behind the end of the events, and a word cut by it, are counted") {
    const RecordingCopy recording;
    std::string bytes = bytes_of(recording.path() / "events.raw");
    bytes.resize(bytes.size() % 2 == 0 ? bytes.size() / 4 * 2 + 1 : bytes.size() / 4 * 2);
    recording.write("events.raw", bytes);
    const json report = report_of(recording);
    CHECK(report["faults"]["event_malformed"] == 1);
    const int without = report["faults"]["frame_without_events"].get<int>();
    CHECK(without > 5);
    CHECK(without < report["frames"]["in"].get<int>() - 5);
    CHECK(json::parse(undisturbed().report())["faults"].empty());
  }

  TEST_CASE("events outside the sensor and lines that do not read are counted, not used") {
    const RecordingCopy recording;
    recording.remove("events.raw");
    recording.write(
        "events.txt",
        "0.1 5 5 1\n0.2 1000 4 1\n0.2 4 1000 0\nx\n0.3 239 179 1\n2.4 0 0 0\n2.4 1 0 0\n");
    const json report = report_of(recording, {"--duration", "2.45"});
    CHECK(report["faults"] == json{{"event_malformed", 1}, {"event_outside_sensor", 2}});
    CHECK(report["events"]["in"] == 6);  // those that read
    CHECK(report["events"]["dropped"] == 2);
  }

  TEST_CASE("one broken number in the inertial data is dropped, counted, and costs no accuracy") {
    for (const char* number : {"2000", "-200", "1e9"}) {
      CAPTURE(number);
      const RecordingCopy recording;
      std::vector<std::string> imu = recording.lines("imu.txt");
      const std::size_t from = imu[350].find(' ') + 1;
      imu[350].replace(from, imu[350].find(' ', from) - from, number);
      recording.set_lines("imu.txt", imu);
      const json report = report_of(recording);
      CHECK(report["faults"] == json{{"imu_implausible", 1}});
      CHECK(report["resets"] == 0);
      CHECK(report["accuracy"]["ate_rmse_m"] < kLargestAte_m);
    }
  }

  TEST_CASE("one stamp far in the future costs its line, not the rest of the recording") {
    const RecordingCopy frames;
    std::vector<std::string> images = frames.lines("images.txt");
    images[30] = "90000.000000000 images/frame_00000030.png";
    frames.set_lines("images.txt", images);
    CHECK(report_of(frames)["frames"]["used"] == kFrames - 1);

    const RecordingCopy inertial;
    std::vector<std::string> imu = inertial.lines("imu.txt");
    imu[300].replace(0, 1, "90001");
    inertial.set_lines("imu.txt", imu);
    const json report = report_of(inertial);
    CHECK(report["frames"]["used"] == kFrames);
    CHECK(report["accuracy"]["ate_rmse_m"] < kLargestAte_m);
  }
}

}  // namespace
