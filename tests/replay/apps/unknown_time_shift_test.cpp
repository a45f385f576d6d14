#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;
namespace fs = std::filesystem;

/// Seven seconds of flight, frames and events stamped `shift_s` too early and no word of it.
fs::path make_recording(double shift_s) {
  const fs::path folder = fs::path(PLED_TEST_FOLDER) / "unknown-shift";
  const Outcome o =
      run_pled_vins({"simulate", "--preset", "test", "--duration", "7", "--camera-late",
                     std::to_string(-shift_s), "--out", folder.string(), "--force"});
  REQUIRE_MESSAGE(o.code == 0, o.err);
  return folder;
}

TEST_SUITE("apps.replay_unknown_time_shift") {
  TEST_CASE("clocks 60 ms apart are found, told, and then track as well as known ones") {
    const fs::path recording = make_recording(0.06);
    const fs::path out = fs::path(PLED_TEST_FOLDER) / "unknown-shift-out";
    const Outcome o = run_pled_vins(
        {"replay", recording.string(), "--out", out.string(), "--force", "--no-report"});
    REQUIRE_MESSAGE(o.code == 0, o.err);
    const auto report = nlohmann::json::parse(bytes_of(out / "report.json"));
    CHECK(report["faults"]["time_shift_corrected"] == 1);
    CHECK(contains(o.err, "timeshift_cam_imu: 0.0"));
    REQUIRE(report["accuracy"]["ate_rmse_m"].is_number());
    MESSAGE("ATE " << report["accuracy"]["ate_rmse_m"] << " m, started after "
                   << report["initialised_at_s"] << " s");
    CHECK(report["accuracy"]["ate_rmse_m"] < 0.03);

    // The events' clock is the same camera's: it is corrected too, or nothing would start by them.
    const Outcome events = run_pled_vins({"replay", recording.string(), "--out", out.string(),
                                          "--force", "--no-report", "--no-frames"});
    REQUIRE_MESSAGE(events.code == 0, events.err);
    const auto seen = nlohmann::json::parse(bytes_of(out / "report.json"));
    CHECK(seen["faults"]["time_shift_corrected"] == 1);
    MESSAGE("by events: ATE " << seen["accuracy"]["ate_rmse_m"] << " m, started after "
                              << seen["initialised_at_s"] << " s");
    CHECK(seen["accuracy"]["ate_rmse_m"] < 0.1);
    CHECK(seen["initialised_at_s"] <
          5.5);  // 4.3 s were seen, 6.4 s with the events' clock as it was

    const Outcome off = run_pled_vins({"config", "--print-default"});
    std::string text = off.out;
    const std::string key = "find_time_shift: true";
    REQUIRE(text.find(key) != std::string::npos);
    text.replace(text.find(key), key.size(), "find_time_shift: false");
    const fs::path config = fs::path(PLED_TEST_FOLDER) / "unknown-shift.yaml";
    std::ofstream(config) << text;
    const Outcome without = run_pled_vins({"replay", recording.string(), "--out", out.string(),
                                           "--force", "--config", config.string()});
    CHECK(without.code == 0);
    const auto lost = nlohmann::json::parse(bytes_of(out / "report.json"));
    CHECK(!lost["faults"].contains("time_shift_corrected"));
    fs::remove_all(recording);
    fs::remove_all(out);
  }
}

}  // namespace
