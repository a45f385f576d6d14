#include <cstdlib>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "pled_vins/config/calibration.hpp"

namespace {

/// The folder of recordings; null, with a message, when it is not named.
const char* recordings() {
  const char* folder = std::getenv("PLED_RECORDINGS");
  if (folder == nullptr) MESSAGE("skipped: PLED_RECORDINGS is not set");
  return folder;
}

TEST_SUITE("config.recorded_calibration") {
  TEST_CASE("the calibration of every recording that has one is read unchanged") {
    const char* folder = recordings();
    if (folder == nullptr) return;
    int found = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (entry.path().filename() != "camchain.yaml") continue;
      const std::filesystem::path recording = entry.path().parent_path();
      CAPTURE(recording.string());
      const auto read = pled::load_calibration(recording, {});
      if (const auto* error = std::get_if<pled::ConfigError>(&read)) FAIL_CHECK(error->message());
      if (const auto* loaded = std::get_if<pled::LoadedCalibration>(&read)) {
        CHECK(loaded->notes.empty());
        CHECK(loaded->rig.num_cameras == 1);
        CHECK(loaded->rig.imu.rate_hz >= 100.0);
        ++found;
      }
    }
    CHECK(found > 0);
  }

  TEST_CASE("calib.txt alone is refused with words") {
    const char* folder = recordings();
    if (folder == nullptr) return;
    const auto read =
        pled::load_calibration(std::filesystem::path(folder) / "real/davis240c_slider_depth", {});
    REQUIRE(std::holds_alternative<pled::ConfigError>(read));
    CHECK(std::get<pled::ConfigError>(read).key == "T_cam_imu");
  }
}

}  // namespace
