// What the options of replay mean, and what it answers to wrong ones.

#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;

/// Stamps of the first and the last row of features.csv, s.
std::pair<double, double> played_span(const RecordingCopy& recording) {
  const std::vector<std::string> lines = lines_of(recording.out() / "features.csv");
  if (lines.size() < 2) return {-1.0, -1.0};
  return {std::stod(csv_fields(lines[1])[0]), std::stod(csv_fields(lines.back())[0])};
}

TEST_SUITE("apps.replay_options") {
  TEST_CASE("start and duration count from the first frame, not from zero of the clock") {
    const RecordingCopy recording;
    std::vector<std::string> images = recording.lines("images.txt");
    images.erase(images.begin(), images.begin() + 4);  // begins at 0.2 s
    recording.set_lines("images.txt", images);
    REQUIRE(recording.replay({"--start", "0.5", "--duration", "1"}).code == 0);
    const auto [first_s, last_s] = played_span(recording);
    CHECK(first_s == doctest::Approx(0.7));
    CHECK(last_s == doctest::Approx(1.7));
    const auto report = nlohmann::json::parse(recording.report());
    CHECK(report["frames"]["in"] == 21);
    CHECK(report["duration_s"] == doctest::Approx(1.0));
    CHECK(report["imu"]["in"].get<int>() >= 200);
    CHECK(report["imu"]["in"].get<int>() <= 215);  // and 50 ms of lead
    for (const TumPose& pose : read_tum(recording.out() / "trajectory.tum")) CHECK(pose.t_s >= 0.7);
  }

  TEST_CASE("a duration ends the run and changes nothing of what was before") {
    const RecordingCopy recording;
    REQUIRE(recording.replay().code == 0);
    const std::string whole = bytes_of(recording.out() / "trajectory.tum");
    REQUIRE(recording.replay({"--duration", "1.5"}).code == 0);
    const std::string part = bytes_of(recording.out() / "trajectory.tum");
    CHECK(part != "");
    CHECK(part.size() < whole.size());
    CHECK(whole.starts_with(part));  // never revised, smoothed or filled in later
  }

  TEST_CASE("options may stand before the command, before the recording and behind it") {
    const RecordingCopy recording;
    const std::string path = recording.path().string();
    const std::string out = recording.out().string();
    REQUIRE(recording.replay({"--duration", "0.5"}).code == 0);
    const std::string features = bytes_of(recording.out() / "features.csv");
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"--duration", "0.5", "--force", "--out", out, "replay", path},
          std::vector<std::string>{"replay", "--out", out, "--duration=0.5", "--force", path},
          std::vector<std::string>{"--force", "replay", path, "--duration", "0.5", "--out", out}}) {
      std::filesystem::remove(recording.out() / "features.csv");
      const Outcome o = run_pled_vins(words);
      CHECK_MESSAGE(o.code == 0, o.err);
      CHECK(bytes_of(recording.out() / "features.csv") == features);
    }
  }

  TEST_CASE("results are kept without --force, and words say how to replace them") {
    const RecordingCopy recording;
    std::filesystem::create_directories(recording.out());
    const std::string path = recording.path().string();
    const std::vector<std::string> words{"replay",     path, "--out", recording.out().string(),
                                         "--duration", "0.2"};
    REQUIRE(run_pled_vins(words).code == 0);
    const std::string features = bytes_of(recording.out() / "features.csv");
    const Outcome again = run_pled_vins(words);
    CHECK(again.code == 1);
    CHECK_MESSAGE(contains(again.err, "--force"), again.err);
    CHECK(again.out == "");
    CHECK(bytes_of(recording.out() / "features.csv") == features);
    CHECK(recording.replay({"--duration", "0.2"}).code == 0);
  }

  TEST_CASE("wrong options exit with 2 in words that fit a line, and touch no result") {
    const RecordingCopy recording;
    for (const std::vector<std::string>& more : {std::vector<std::string>{"--start", "-1"},
                                                 {"--start", "nan"},
                                                 {"--start", "soon"},
                                                 {"--duration", "0"},
                                                 {"--duration", "-3"},
                                                 {"--duration", "inf"},
                                                 {"--duration", "nan"},
                                                 {"--duration", "1e300"},
                                                 {"--speed", "2"},
                                                 {"--start"}}) {
      CAPTURE(more.front());
      CAPTURE(more.back());
      const Outcome o = recording.replay(more);
      CHECK(o.code == 2);
      CHECK(o.out == "");
      CHECK_MESSAGE(contains(o.err, more.front()), o.err);
      CHECK_MESSAGE(o.err.size() < 200, o.err);
      CHECK(!std::filesystem::exists(recording.out()));
    }
    CHECK(run_pled_vins({"replay", recording.path().string()}).code == 2);  // --out is missing
    CHECK(run_pled_vins({"replay", "--out", recording.out().string()}).code == 2);
  }

  TEST_CASE("a start behind the last frame is refused before results are touched") {
    const RecordingCopy recording;
    const Outcome o = recording.replay({"--start", "100"});
    CHECK(o.code == 1);
    CHECK_MESSAGE(contains(o.err, "--start"), o.err);
    CHECK_MESSAGE(contains(o.err, "2.45"), o.err);  // how long the frames last
    CHECK(!std::filesystem::exists(recording.out() / "trajectory.tum"));
  }

  TEST_CASE("a misspelt setting is refused with file, line and the nearest key") {
    const RecordingCopy recording;
    recording.write("my.yaml", "# mine\nfrontend:\n  max_pointz: 3\n");
    const std::string config = (recording.path() / "my.yaml").string();
    const Outcome o = recording.replay({"--config", config});
    CHECK(o.code == 1);
    CHECK_MESSAGE(contains(o.err, config + ":3: frontend.max_pointz"), o.err);
    CHECK_MESSAGE(contains(o.err, "frontend.max_points"), o.err);
    CHECK(!std::filesystem::exists(recording.out()));
  }

  TEST_CASE("a run that ends before the start is done, with words about why it has not started") {
    const RecordingCopy recording;
    const Outcome o = recording.replay({"--duration", "0.2"});
    CHECK(o.code == 0);
    CHECK_MESSAGE(contains(o.err, "never started: "), o.err);
    CHECK(bytes_of(recording.out() / "trajectory.tum") == "");
  }
}

}  // namespace
