#include <filesystem>
#include <limits>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "src/apps/output_features.hpp"
#include "src/apps/output_file.hpp"
#include "src/apps/output_report.hpp"
#include "src/apps/output_trajectory.hpp"
#include "unit/config/text_file.hpp"

namespace {

using namespace pled::apps;
using pled::support::read_all;
using pled::support::ScratchFolder;

std::string stamp_text(std::int64_t ns) {
  char text[32];
  return {text, format_stamp(ns, text)};
}

TEST_SUITE("apps.output") {
  TEST_CASE("a stamp is written exactly, whatever its size and sign") {
    CHECK(stamp_text(0) == "0.000000000");
    CHECK(stamp_text(50'000'000) == "0.050000000");
    CHECK(stamp_text(1403715273262143135) == "1403715273.262143135");
    CHECK(stamp_text(-1) == "-0.000000001");
    CHECK(stamp_text(-1'500'000'000) == "-1.500000000");
    CHECK(stamp_text(std::numeric_limits<std::int64_t>::min()) == "-9223372036.854775808");
  }

  TEST_CASE("trajectory.tum has the recording's stamp and nine decimals, at once") {
    const ScratchFolder folder;
    TrajectoryWriter writer;
    REQUIRE(writer.open(folder.path()));
    pled::PoseEstimate pose;
    pose.stamp_ns = 1403715273262143135;
    pose.t = {1403715273262143};
    pose.p_world_body_m = {1.0, -2.5, 1.0 / 3.0};
    pose.q_world_body_xyzw = {0.5, -0.5, 0.5, 0.5};
    REQUIRE(writer.write(pose).ok());
    const std::string want =
        "1403715273.262143135 1.000000000 -2.500000000 0.333333333 "
        "0.500000000 -0.500000000 0.500000000 0.500000000\n";
    CHECK(read_all(folder.path() / "trajectory.tum") == want);  // before close()
    CHECK(writer.close());
    CHECK(read_all(folder.path() / "trajectory.tum") == want);
  }

  TEST_CASE("a pose that is not finite is refused and writes nothing") {
    const ScratchFolder folder;
    TrajectoryWriter writer;
    REQUIRE(writer.open(folder.path()));
    pled::PoseEstimate pose;
    pose.p_world_body_m[1] = std::numeric_limits<double>::quiet_NaN();
    CHECK(writer.write(pose).error().code == pled::ErrorCode::kBadNumber);
    pose.p_world_body_m[1] = 0;
    pose.q_world_body_xyzw[0] = std::numeric_limits<double>::infinity();
    CHECK(writer.write(pose).error().code == pled::ErrorCode::kBadNumber);
    CHECK(writer.close());
    CHECK(read_all(folder.path() / "trajectory.tum").empty());
  }

  TEST_CASE("features.csv leaves cues without evidence and second ends empty") {
    const ScratchFolder folder;
    FeaturesWriter writer;
    REQUIRE(writer.open(folder.path()));
    static pled::FrameMeasurement frame;
    frame.stamp_ns = 50'000'000;
    REQUIRE(frame.points.resize(2));
    frame.points[0].id = 7;
    frame.points[0].raw_px = {12.5, 100.25};
    frame.points[1].id = 4000000000;
    frame.points[1].kind = pled::FeatureKind::kEventPoint;
    frame.points[1].raw_px = {0, 179};
    std::array<pled::FeatureWeight, 2> weights;
    weights[0] = {.id = 7, .w_geometric = 0.25, .w = 0.25, .observations = 4, .used = true};
    weights[1] = {.id = 4000000000, .w_temporal = 1.0 / 3.0, .w = 0.0};
    REQUIRE(writer.write_frame(frame, weights, {}));
    CHECK(writer.close());
    CHECK(read_all(folder.path() / "features.csv") ==
          "t,id,kind,u0_px,v0_px,u1_px,v1_px,w_temporal,w_geometric,w,observations,used\n"
          "0.050000000,7,image_point,12.5000,100.2500,,,,0.250000,0.250000,4,1\n"
          "0.050000000,4000000000,event_point,0.0000,179.0000,,,0.333333,,0.000000,0,0\n");
  }

  TEST_CASE("features.csv has both ends of a line, weighed or not") {
    const ScratchFolder folder;
    FeaturesWriter writer;
    REQUIRE(writer.open(folder.path()));
    static pled::FrameMeasurement frame;
    frame.stamp_ns = 50'000'000;
    REQUIRE(frame.lines.resize(2));
    frame.lines[0].id = pled::kFirstImageLineId;
    frame.lines[0].raw_px = {{{1.5, 2.0}, {30.25, 179.0}}};
    frame.lines[1].id = pled::kFirstEventLineId;
    frame.lines[1].raw_px = {{{0.0, 4.0}, {60.0, 4.5}}};
    frame.lines[1].w_temporal = 0.75;
    REQUIRE(writer.write_frame(frame, {}, {}));
    std::array<pled::FeatureWeight, 2> weights;
    weights[0] = {.id = pled::kFirstImageLineId, .w = 0.0};
    weights[1] = {.id = pled::kFirstEventLineId,
                  .w_temporal = 0.75,
                  .w_geometric = 0.5,
                  .w = 0.625,
                  .observations = 3,
                  .used = true};
    REQUIRE(writer.write_frame(frame, {}, weights));
    CHECK(writer.close());
    CHECK(read_all(folder.path() / "features.csv") ==
          std::string(FeaturesWriter::kHeader) +
              "0.050000000,1073741825,line,1.5000,2.0000,30.2500,179.0000,,,,0,0\n"
              "0.050000000,3221225473,line,0.0000,4.0000,60.0000,4.5000,0.750000,,,0,0\n"
              "0.050000000,1073741825,line,1.5000,2.0000,30.2500,179.0000,,,0.000000,0,0\n"
              "0.050000000,3221225473,line,0.0000,4.0000,60.0000,4.5000,0.750000,0.500000,"
              "0.625000,3,1\n");
  }

  TEST_CASE("a full disk is noticed by the writer and told in words") {
    if (!std::filesystem::exists("/dev/full")) {
      MESSAGE("skipped: there is no /dev/full");
      return;
    }
    const ScratchFolder folder;
    std::filesystem::create_symlink("/dev/full", folder.path() / "trajectory.tum");
    std::filesystem::create_symlink("/dev/full", folder.path() / "features.csv");
    std::filesystem::create_symlink("/dev/full", folder.path() / "report.json.part");
    TrajectoryWriter poses;
    REQUIRE(poses.open(folder.path()));
    CHECK(poses.write({}).error().code == pled::ErrorCode::kIoFailure);
    CHECK(poses.write({}).error().code == pled::ErrorCode::kIoFailure);  // and stays so
    CHECK_FALSE(poses.close());
    CHECK(poses.error().find("No space left") != std::string::npos);
    CHECK(poses.error().find("trajectory.tum") != std::string::npos);
    FeaturesWriter features;
    REQUIRE(features.open(folder.path()));
    static pled::FrameMeasurement nothing;
    CHECK_FALSE(features.write_frame(nothing, {}, {}));
    CHECK(features.error().find("features.csv") != std::string::npos);
    CHECK(write_report({}, folder.path()).find("No space left") != std::string::npos);
  }

  TEST_CASE("a folder that cannot be made or is a file is refused in words") {
    const ScratchFolder folder;
    const auto file = folder.write("file", "x");
    CHECK(prepare_output_folder(file, {"a"}, false).find("not a folder") != std::string::npos);
    CHECK(prepare_output_folder(file / "below", {"a"}, false).find("cannot") != std::string::npos);
    CHECK(prepare_output_folder("/proc/nowhere/out", {"a"}, false).find("cannot create") !=
          std::string::npos);
  }

  TEST_CASE("results are not overwritten without force, other files stay in any case") {
    const ScratchFolder folder;
    const auto out = folder.path() / "deep" / "out";
    CHECK(prepare_output_folder(out, {"a.txt", "b.txt"}, false).empty());
    CHECK(std::filesystem::is_empty(out));  // the trial file is gone
    folder.write("deep/out/b.txt", "old");
    folder.write("deep/out/mine.txt", "mine");
    const std::string refusal = prepare_output_folder(out, {"a.txt", "b.txt"}, false);
    CHECK(refusal.find("b.txt exists already") != std::string::npos);
    CHECK(refusal.find("--force") != std::string::npos);
    CHECK(read_all(out / "b.txt") == "old");
    CHECK(prepare_output_folder(out, {"a.txt", "b.txt"}, true).empty());
    CHECK_FALSE(std::filesystem::exists(out / "b.txt"));
    CHECK(read_all(out / "mine.txt") == "mine");
  }

  TEST_CASE("report.json has every key in order, and null for what is absent") {
    const auto json = nlohmann::ordered_json::parse(to_json({}));
    std::vector<std::string> keys;
    for (const auto& item : json.items()) keys.push_back(item.key());
    CHECK(keys == std::vector<std::string>{"schema", "version", "recording", "duration_s",
                                           "initialised_at_s", "accuracy", "stages",
                                           "cpu_ms_per_frame", "features_per_frame", "streams_used",
                                           "events", "imu", "frames", "memory", "faults", "resets",
                                           "reset_stamps_s"});
    for (const char* key : {"duration_s", "initialised_at_s", "cpu_ms_per_frame", "events"})
      CHECK(json.at(key).is_null());
    for (const char* key : {"ate_rmse_m", "mpe_percent", "rpe_trans_m", "rpe_rot_deg", "coverage"})
      CHECK(json.at("accuracy").at(key).is_null());
    for (const char* key : {"image_points", "event_points", "lines"})
      CHECK(json.at("features_per_frame").at(key).is_null());
    for (const char* key : {"static_bytes", "peak_rss_bytes", "allocations_after_start"})
      CHECK(json.at("memory").at(key).is_null());
    CHECK(json.at("stages").is_object());
    CHECK(json.at("faults").is_object());
    CHECK(json.at("resets") == 0);
  }

  TEST_CASE("a report is written whole, numbers as given, NaN as null, any name as text") {
    const ScratchFolder folder;
    ReplayReport report;
    report.recording = "bad\xff name";
    report.accuracy.ate_rmse_m = 0.1;
    report.accuracy.mpe_percent = std::numeric_limits<double>::quiet_NaN();
    report.stages.push_back({"frontend", 1.5, 2.5, 3.5});
    report.events = FlowReport{10, 8, 2};
    report.memory.allocations_after_start = 0;
    report.faults = {{"imu_gap", 3}};
    report.resets = 2;
    CHECK(write_report(report, folder.path()) == "");
    const auto json = nlohmann::json::parse(read_all(folder.path() / "report.json"));
    CHECK(json["accuracy"]["ate_rmse_m"] == 0.1);
    CHECK(json["accuracy"]["mpe_percent"].is_null());
    CHECK(json["stages"]["frontend"]["p99_us"] == 2.5);
    CHECK(json["events"]["dropped"] == 2);
    CHECK(json["memory"]["allocations_after_start"] == 0);
    CHECK(json["faults"]["imu_gap"] == 3);
    CHECK(json["resets"] == 2);
    CHECK_FALSE(std::filesystem::exists(folder.path() / "report.json.part"));
  }
}

}  // namespace
