// How large the sensors are: the RAW header, the calibration of each camera, the images.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "pled_vins/core/image_view.hpp"
#include "src/sim/png_file.hpp"
#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;
namespace fs = std::filesystem;

/// Adds cam1, an event camera of its own, to the calibration and writes the settings
/// that name it.
void add_event_camera(const RecordingCopy& recording, int width, int height) {
  std::string chain = bytes_of(recording.path() / "camchain.yaml");
  std::string second = chain;
  const auto put = [&second](const std::string& key, const std::string& value) {
    const std::size_t at = second.find(key);
    REQUIRE(at != std::string::npos);
    second.replace(at, second.find('\n', at) - at, key + value);
  };
  put("cam0:", "");
  second.replace(second.find("cam0:"), 5, "cam1:");
  put("resolution: ", "[" + std::to_string(width) + ", " + std::to_string(height) + "]");
  put("intrinsics: ",
      "[260, 260, " + std::to_string(width / 2) + ", " + std::to_string(height / 2) + "]");
  recording.write("camchain.yaml", chain + second);
  recording.write("my.yaml", "sensors:\n  frame_camera: cam0\n  event_camera: cam1\n");
}

std::vector<std::string> with_settings(const RecordingCopy& recording) {
  return {"--config", (recording.path() / "my.yaml").string()};
}

/// 15000 events over all of 320 x 240 pixels in 2.4 s.
void write_large_events(const RecordingCopy& recording) {
  fs::remove(recording.path() / "events.raw");
  std::string text;
  for (int i = 0; i < 15000; ++i)
    text += std::to_string(1.6e-4 * i) + " " + std::to_string(i % 320) + " " +
            std::to_string(i % 240) + " " + std::to_string(i % 2) + "\n";
  recording.write("events.txt", text);
}

void write_image(const RecordingCopy& recording, const std::string& name, int width, int height) {
  recording.remove(name);
  const std::vector<std::uint8_t> grey(static_cast<std::size_t>(width * height), 128);
  REQUIRE(pled::sim::write_png(recording.path() / name, {grey.data(), width, height, width}).ok());
}

TEST_SUITE("apps.replay_sizes") {
  TEST_CASE("an event camera larger than the frame camera keeps all of its events") {
    const RecordingCopy recording;
    write_large_events(recording);
    add_event_camera(recording, 320, 240);
    const Outcome o = recording.replay(with_settings(recording));
    REQUIRE_MESSAGE(o.code == 0, o.err);
    const auto report = nlohmann::json::parse(recording.report());
    CHECK(report["events"]["in"] == 15000);
    CHECK_MESSAGE(!report["faults"].contains("event_outside_sensor"), report["faults"].dump());

    std::vector<std::string> words{"info", recording.path().string(), "--json"};
    const auto settings = with_settings(recording);
    words.insert(words.end(), settings.begin(), settings.end());
    const auto info = nlohmann::json::parse(run_pled_vins(words).out);
    CHECK(info["events"]["count"] == 15000);
    CHECK(info["events"]["width"] == 320);
    CHECK(info["problems"].empty());
  }

  TEST_CASE("an event camera that no sensor class holds is refused with its size") {
    const RecordingCopy recording;
    write_large_events(recording);
    add_event_camera(recording, 1920, 1080);
    const Outcome o = recording.replay(with_settings(recording));
    CHECK(o.code == 1);
    CHECK_MESSAGE(contains(o.err, "1920x1080"), o.err);
    CHECK_MESSAGE(contains(o.err, "1280x720"), o.err);
    const Outcome info = run_pled_vins(
        {"info", recording.path().string(), "--config", (recording.path() / "my.yaml").string()});
    CHECK(info.code == 0);
    CHECK_MESSAGE(contains(info.out, "problem   the recording's sensor has 1920x1080"), info.out);
  }

  TEST_CASE("a RAW header that contradicts the calibration is refused with both sizes") {
    const RecordingCopy recording;
    add_event_camera(recording, 320, 240);
    const Outcome o = recording.replay(with_settings(recording));
    CHECK(o.code == 1);
    for (const char* word : {"events.raw", "240x180", "320x240", "sensors.event_camera"})
      CHECK_MESSAGE(contains(o.err, word), o.err);
    const Outcome info = run_pled_vins(
        {"info", recording.path().string(), "--config", (recording.path() / "my.yaml").string()});
    CHECK_MESSAGE(contains(info.out, "320x240"), info.out);
  }

  TEST_CASE("first images that are missing or of another size cost themselves alone") {
    const RecordingCopy recording;
    for (int i = 0; i < 20; ++i) {
      const std::string number = std::to_string(i);
      recording.remove("images/frame_" + std::string(8 - number.size(), '0') + number + ".png");
    }
    Outcome o = recording.replay();
    REQUIRE_MESSAGE(o.code == 0, o.err);
    CHECK(nlohmann::json::parse(recording.report())["faults"]["frame_unreadable"] == 20);

    const RecordingCopy other;
    write_image(other, "images/frame_00000000.png", 320, 240);
    write_image(other, "images/frame_00000001.png", 120, 90);
    o = other.replay();
    REQUIRE_MESSAGE(o.code == 0, o.err);
    CHECK(nlohmann::json::parse(other.report())["faults"]["frame_unreadable"] == 2);
    CHECK(!read_tum(other.out() / "trajectory.tum").empty());
  }
}

}  // namespace
