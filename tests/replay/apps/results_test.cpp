// What a replay writes, and how good it is.

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;

std::vector<std::string> listed_stamps(const RecordingCopy& recording) {
  std::vector<std::string> stamps;
  for (const std::string& line : recording.lines("images.txt"))
    stamps.push_back(line.substr(0, line.find(' ')));
  return stamps;
}

bool has_nine_decimals(const std::string& number) {
  const std::size_t point = number.find('.');
  return point != std::string::npos && number.size() == point + 10;
}

/// A weight or cue: empty, or in [0, 1].
bool is_weight(const std::string& field) {
  if (field.empty()) return true;
  const double value = std::stod(field);
  return value >= 0.0 && value <= 1.0;
}

/// A pixel coordinate inside a sensor `size` pixels wide.
bool is_inside(const std::string& field, double size) {
  const double value = std::stod(field);
  return value >= 0.0 && value <= size - 1.0;
}

/// What is wrong with a row of features.csv, in a word; empty when nothing is.
std::string fault_of_row(const std::vector<std::string>& row) {
  if (row.size() != 12) return "columns";
  if (!has_nine_decimals(row[0])) return "t";
  if (row[1].empty() || row[1].find_first_not_of("0123456789") != std::string::npos) return "id";
  const bool is_line = row[2] == "line";
  if (row[2] != "image_point" && row[2] != "event_point" && !is_line) return "kind";
  if (!is_inside(row[3], 240.0)) return "u0_px";
  if (!is_inside(row[4], 180.0)) return "v0_px";
  if (is_line && !(is_inside(row[5], 240.0) && is_inside(row[6], 180.0))) return "end of a line";
  if (!is_line && !(row[5].empty() && row[6].empty())) return "u1_px and v1_px of a point";
  if (!is_weight(row[7]) || !is_weight(row[8]) || !is_weight(row[9])) return "weight";
  if (row[10].empty() || row[10].find_first_not_of("0123456789") != std::string::npos)
    return "observations";
  if (row[11] != "0" && row[11] != "1") return "used";
  return {};
}

TEST_SUITE("apps.replay_results") {
  TEST_CASE(
      "trajectory.tum has a unit quaternion and nine decimals for every frame from the start") {
    const RecordingCopy recording;
    const Outcome o = recording.replay();
    REQUIRE_MESSAGE(o.code == 0, o.err);
    const std::vector<TumPose> poses = read_tum(recording.out() / "trajectory.tum");
    const std::vector<std::string> stamps = listed_stamps(recording);
    REQUIRE(poses.size() >= 10);
    REQUIRE(poses.size() <= stamps.size());
    // Once started no frame is left out: the stamps are the end of the list, as it has them.
    const std::size_t before = stamps.size() - poses.size();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      CAPTURE(i);
      CHECK(poses[i].stamp == stamps[before + i]);
      const auto& q = poses[i].q;
      const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
      CHECK(std::abs(norm - 1.0) < 5e-9);  // four numbers rounded to nine decimals
    }
    for (const std::string& line : lines_of(recording.out() / "trajectory.tum")) {
      CAPTURE(line);
      std::string rest = line + " ";
      CHECK(std::count(rest.begin(), rest.end(), ' ') == 8);
      for (std::size_t space = rest.find(' '); space != std::string::npos; space = rest.find(' ')) {
        CHECK(has_nine_decimals(rest.substr(0, space)));
        rest.erase(0, space + 1);
      }
    }
  }

  TEST_CASE(
      "features.csv has rows for every frame, also before the start, and each is well formed") {
    const RecordingCopy recording;
    REQUIRE(recording.replay().code == 0);
    const std::vector<std::string> lines = lines_of(recording.out() / "features.csv");
    REQUIRE(lines.size() > 1);
    CHECK(lines.front() ==
          "t,id,kind,u0_px,v0_px,u1_px,v1_px,w_temporal,w_geometric,w,observations,used");
    std::set<std::string> stamps;
    std::set<std::string> rows;
    bool any_used = false;
    for (std::size_t i = 1; i < lines.size(); ++i) {
      const std::vector<std::string> row = csv_fields(lines[i]);
      const std::string fault = fault_of_row(row);
      REQUIRE_MESSAGE(fault.empty(), fault << " in line " << i + 1 << ": " << lines[i]);
      CHECK_MESSAGE(rows.insert(row[0] + " " + row[1]).second, "twice: " << lines[i]);
      stamps.insert(row[0]);
      if (row[11] == "1") {
        any_used = true;
        CHECK_MESSAGE(!row[9].empty(), "used without a weight: " << lines[i]);
      }
    }
    const std::vector<std::string> listed = listed_stamps(recording);
    CHECK(stamps == std::set<std::string>(listed.begin(), listed.end()));
    CHECK(any_used);
  }

  TEST_CASE(
      "report.json has every key of the schema, with true counts and null for what is absent") {
    const RecordingCopy recording;
    REQUIRE(recording.replay().code == 0);
    const auto report = nlohmann::json::parse(recording.report());
    std::vector<std::string> keys;
    for (const auto& item : report.items()) keys.push_back(item.key());
    std::sort(keys.begin(), keys.end());
    CHECK(keys == std::vector<std::string>{"accuracy", "cpu_ms_per_frame", "duration_s", "events",
                                           "faults", "features_per_frame", "frames", "imu",
                                           "initialised_at_s", "memory", "recording",
                                           "reset_stamps_s", "resets", "schema", "stages",
                                           "streams_used", "version"});
    const auto frames = recording.lines("images.txt").size();
    CHECK(report["frames"]["in"] == frames);
    CHECK(report["frames"]["used"] == frames);
    CHECK(report["frames"]["dropped"] == 0);
    CHECK(report["events"]["in"] > 0);
    CHECK(report["imu"]["in"] > 450);  // 2.5 s at 200 Hz, without those after the last frame
    CHECK(report["faults"] == nlohmann::json::object());
    CHECK(report["resets"] == 0);
    CHECK(report["duration_s"] == doctest::Approx(2.45));
    for (const char* stage : {"read", "frontend", "lines", "backend", "frame"}) {
      CAPTURE(stage);
      CHECK(report["stages"][stage]["p50_us"] <= report["stages"][stage]["max_us"]);
      CHECK(report["stages"][stage]["p99_us"] > 0.0);
    }
    CHECK(report["cpu_ms_per_frame"] > 0.0);
    CHECK(report["features_per_frame"]["image_points"] > 20.0);
    CHECK(report["features_per_frame"]["event_points"] > 0.0);
    CHECK(report["features_per_frame"]["lines"] > 5.0);
    CHECK(report["memory"]["static_bytes"] > 0);
    CHECK(report["memory"]["peak_rss_bytes"] > report["memory"]["static_bytes"]);
    for (const char* key :
         {"ate_rmse_m", "mpe_percent", "rpe_trans_m", "rpe_rot_deg", "coverage"}) {
      CAPTURE(key);
      CHECK(report["accuracy"][key].is_number());
    }

    recording.remove("groundtruth.txt");
    recording.remove("events.raw");
    REQUIRE(recording.replay({"--duration", "0.2"}).code == 0);
    const auto bare = nlohmann::json::parse(recording.report());
    CHECK(bare["events"].is_null());
    CHECK(bare["initialised_at_s"].is_null());
    for (const char* key :
         {"ate_rmse_m", "mpe_percent", "rpe_trans_m", "rpe_rot_deg", "coverage"}) {
      CAPTURE(key);
      REQUIRE(bare["accuracy"].contains(key));
      CHECK(bare["accuracy"][key].is_null());
    }
  }

  TEST_CASE("the same recording twice gives the same bytes, and another folder changes none") {
    const RecordingCopy first;
    const RecordingCopy second;
    REQUIRE(first.replay().code == 0);
    REQUIRE(second.replay().code == 0);
    const std::string trajectory = bytes_of(first.out() / "trajectory.tum");
    CHECK(trajectory != "");
    CHECK(trajectory == bytes_of(second.out() / "trajectory.tum"));
    CHECK(bytes_of(first.out() / "features.csv") == bytes_of(second.out() / "features.csv"));
  }

  TEST_CASE(
      "the trajectory follows the simulator's truth, and evaluate says the same as the report") {
    // 5 mm were seen over 3 s of this flight (0.2 % of the path). The bound is six times that:
    // it shall tell a broken estimator, not one that a change made a little worse.
    constexpr double kLargestAte_m = 0.03;
    const RecordingCopy recording;
    REQUIRE(recording.replay().code == 0);
    const Outcome o = run_pled_vins({"evaluate", (recording.out() / "trajectory.tum").string(),
                                     (recording.path() / "groundtruth.txt").string(), "--json"});
    REQUIRE_MESSAGE(o.code == 0, o.err);
    const auto evaluation = nlohmann::json::parse(o.out);
    const auto report = nlohmann::json::parse(recording.report());
    CHECK(evaluation["ate_rmse_m"] < kLargestAte_m);
    CHECK(report["initialised_at_s"] <= 1.5);
    // The files hold nine decimals.
    CHECK(std::abs(evaluation["ate_rmse_m"].get<double>() -
                   report["accuracy"]["ate_rmse_m"].get<double>()) < 1e-7);
    CHECK(std::abs(evaluation["coverage"].get<double>() -
                   report["accuracy"]["coverage"].get<double>()) < 1e-9);
  }
}

}  // namespace
