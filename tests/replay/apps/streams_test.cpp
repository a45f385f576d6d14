// Frames without events, events without frames, and the choice of the score.

#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;
using nlohmann::json;

json report_of(const RecordingCopy& recording, const std::vector<std::string>& more) {
  const Outcome o = recording.replay(more);
  REQUIRE_MESSAGE(o.code == 0, o.err);
  return json::parse(recording.report());
}

/// Rows of features.csv of a kind.
std::size_t count_rows(const RecordingCopy& recording, const std::string& kind) {
  std::size_t n = 0;
  for (const std::string& line : lines_of(recording.out() / "features.csv"))
    n += csv_fields(line)[2] == kind ? 1U : 0U;
  return n;
}

/// Lines in features.csv that frames and events showed.
struct LineRows {
  std::size_t of_frames = 0;
  std::size_t of_events = 0;
};
LineRows line_rows(const RecordingCopy& recording) {
  constexpr unsigned long kFirstEventLine = 0xC0000001UL;  // src/frontend/lines/README.md
  LineRows rows;
  for (const std::string& line : lines_of(recording.out() / "features.csv")) {
    const std::vector<std::string> fields = csv_fields(line);
    if (fields[2] != "line") continue;
    ++(std::stoul(fields[1]) >= kFirstEventLine ? rows.of_events : rows.of_frames);
  }
  return rows;
}

/// Stamps in features.csv, each once.
std::vector<std::string> stamps_seen(const RecordingCopy& recording) {
  std::vector<std::string> stamps;
  for (const std::string& line : lines_of(recording.out() / "features.csv")) {
    const std::string stamp = csv_fields(line)[0];
    if (stamp != "t" && (stamps.empty() || stamps.back() != stamp)) stamps.push_back(stamp);
  }
  return stamps;
}

/// Stamps that the recording lists.
std::set<std::string> listed_stamps(const RecordingCopy& recording) {
  std::set<std::string> stamps;
  for (const std::string& line : recording.lines("images.txt"))
    stamps.insert(line.substr(0, line.find(' ')));
  return stamps;
}

TEST_SUITE("apps.replay_streams") {
  TEST_CASE("both streams are used by default, and the report says so") {
    const RecordingCopy recording;
    const json report = report_of(recording, {"--duration", "0.5"});
    CHECK(report["streams_used"] == json{{"frames", true}, {"events", true}});
    CHECK(count_rows(recording, "image_point") > 0);
    CHECK(count_rows(recording, "event_point") > 0);
  }

  TEST_CASE("without events frames alone find the trajectory, and events are not looked at") {
    const RecordingCopy recording;
    const json report = report_of(recording, {"--no-events"});
    CHECK(report["streams_used"] == json{{"frames", true}, {"events", false}});
    CHECK(report["events"]["in"] == 0);
    CHECK(report["faults"].empty());
    CHECK(count_rows(recording, "event_point") == 0);
    CHECK(report["accuracy"]["ate_rmse_m"] < 0.03);
    // Bytes that nobody reads change nothing, be they events or not.
    const std::string trajectory = bytes_of(recording.out() / "trajectory.tum");
    recording.remove("events.raw");
    const json gone = report_of(recording, {});
    CHECK(gone["streams_used"] == json{{"frames", true}, {"events", false}});
    CHECK(gone["events"].is_null());
    CHECK(bytes_of(recording.out() / "trajectory.tum") == trajectory);
  }

  TEST_CASE("without frames all points are the events', at the frames' stamps, no picture read") {
    const RecordingCopy recording;
    recording.write("images/frame_00000030.png", "no image");
    const json report = report_of(recording, {"--no-frames"});
    CHECK(report["streams_used"] == json{{"frames", false}, {"events", true}});
    CHECK(report["events"]["used"] > 10'000);
    CHECK(report["faults"].empty());
    CHECK(count_rows(recording, "image_point") == 0);
    const std::set<std::string> listed = listed_stamps(recording);
    CHECK(report["frames"] == json{{"in", listed.size()}, {"used", listed.size()}, {"dropped", 0}});
    const std::vector<std::string> seen = stamps_seen(recording);
    CHECK(seen.size() >= 40);  // of 50: an observation may have no point
    for (const std::string& stamp : seen) CHECK_MESSAGE(listed.contains(stamp), stamp);
    for (const TumPose& pose : read_tum(recording.out() / "trajectory.tum"))
      CHECK(listed.contains(pose.stamp));
  }

  TEST_CASE("lines are of what the settings say, as far as it is looked at") {
    const RecordingCopy recording;
    const auto rows = [&](const std::string& source, const std::vector<std::string>& more) {
      recording.write("my.yaml", "lines:\n  source: " + source + "\n");
      std::vector<std::string> words{"--duration", "0.5", "--config",
                                     (recording.path() / "my.yaml").string()};
      words.insert(words.end(), more.begin(), more.end());
      const Outcome o = recording.replay(words);
      REQUIRE_MESSAGE(o.code == 0, o.err);
      const LineRows found = line_rows(recording);
      const bool wanted = source != "none";
      const bool none = found.of_frames + found.of_events == 0;
      CHECK_MESSAGE(contains(o.err, "lines.source is '" + source + "'") == (wanted && none), o.err);
      const json report = json::parse(recording.report());
      CHECK((report["features_per_frame"]["lines"] == 0.0) == none);
      CHECK(report["stages"].contains("lines") == !none);
      return found;
    };
    CHECK(rows("none", {}).of_frames + rows("none", {}).of_events == 0);
    CHECK(rows("frames", {}).of_frames > 20);
    CHECK(rows("frames", {}).of_events == 0);
    CHECK(rows("events", {}).of_frames == 0);
    CHECK(rows("events", {}).of_events > 20);
    const LineRows both = rows("both", {});
    CHECK(both.of_frames > 20);
    CHECK(both.of_events > 0);
    CHECK(rows("both", {"--no-events"}).of_frames > 20);
    CHECK(rows("both", {"--no-frames"}).of_events > 20);
    CHECK(rows("events", {"--no-events"}).of_frames == 0);
    CHECK(rows("frames", {"--no-frames"}).of_events == 0);
  }

  TEST_CASE("without a list of frames events are observed at 20 Hz, and the coverage is of that") {
    const RecordingCopy recording;
    recording.remove("images.txt");
    std::filesystem::remove_all(recording.path() / "images");
    const json report = report_of(recording, {"--no-frames"});
    CHECK(report["streams_used"] == json{{"frames", false}, {"events", true}});
    const std::vector<std::string> seen = stamps_seen(recording);
    CHECK(seen.size() >= 40);
    for (const std::string& stamp : seen) {
      const double ticks = std::stod(stamp) / 0.05;  // from the first inertial sample, at 0
      CHECK_MESSAGE(std::abs(ticks - std::round(ticks)) < 1e-6, stamp);
    }
    CHECK(report["frames"]["in"] == 51);
    CHECK(report["duration_s"] == doctest::Approx(2.5));
    const double started_s = report["initialised_at_s"].is_number()
                                 ? report["initialised_at_s"].get<double>()
                                 : report["duration_s"].get<double>();
    if (report["accuracy"]["coverage"].is_number())
      CHECK(report["accuracy"]["coverage"] <= 1.001 - started_s / 2.5);
    CHECK(recording.replay().code == 1);  // frames are wanted
  }

  TEST_CASE("without a list of frames wild inertial stamps make no observations") {
    for (const std::size_t at : {std::size_t{0}, std::size_t{300}, std::size_t{500}}) {
      CAPTURE(at);
      const RecordingCopy recording;
      recording.remove("images.txt");
      std::vector<std::string> imu = recording.lines("imu.txt");
      std::string& line = imu[imu.size() - 501 + at];
      line.replace(0, line.find(' '), "90001.000000000");  // 1.8 million times 50 ms
      recording.set_lines("imu.txt", imu);
      const json report = report_of(recording, {"--no-frames"});
      CHECK(report["frames"]["in"].get<int>() >= 49);
      CHECK(report["frames"]["in"].get<int>() <= 52);
    }
  }

  TEST_CASE("with neither stream there is nothing to see by, which is said at once") {
    const RecordingCopy recording;
    const Outcome o = recording.replay({"--no-frames", "--no-events"});
    CHECK(o.code == 2);
    CHECK(o.out == "");
    CHECK_MESSAGE(contains(o.err, "--no-frames and --no-events together"), o.err);
    CHECK(!std::filesystem::exists(recording.out()));
  }

  TEST_CASE("without frames a recording that has no events is refused in words") {
    const RecordingCopy recording;
    recording.remove("events.raw");
    const Outcome o = recording.replay({"--no-frames"});
    CHECK(o.code == 1);
    CHECK_MESSAGE(contains(o.err, "events"), o.err);
    CHECK(!std::filesystem::exists(recording.out()));
  }

  TEST_CASE("a misspelt score is refused with the nearest name and no byte that does not print") {
    const RecordingCopy recording;
    const Outcome o = recording.replay({"--score", "papper"});
    CHECK(o.code == 2);
    CHECK_MESSAGE(contains(o.err, "'papper', did you mean 'paper'?"), o.err);
    for (const char c : o.err) CHECK((c >= ' ' || c == '\n'));
    CHECK(!std::filesystem::exists(recording.out()));
    for (const char* name : {"motion", "paper", "count"}) {
      CAPTURE(name);
      CHECK(recording.replay({"--score", name, "--duration", "0.2"}).code == 0);
    }
  }
}

}  // namespace
