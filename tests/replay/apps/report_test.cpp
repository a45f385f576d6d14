// The page about a replay, and about two.

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;
using Json = nlohmann::json;
namespace fs = std::filesystem;

/// The data inside a page.
Json data_of(const fs::path& page) {
  const std::string text = bytes_of(page);
  const std::string begin = "<script id=\"data\" type=\"application/json\">";
  const std::size_t from = text.find(begin);
  REQUIRE(from != std::string::npos);
  const std::size_t to = text.find("</script>", from);
  REQUIRE(to != std::string::npos);
  return Json::parse(text.substr(from + begin.size(), to - from - begin.size()));
}

Json run_of(const fs::path& page) { return data_of(page).at("runs").at(0); }

Outcome report(const RecordingCopy& recording, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{"report", recording.out().string()};
  words.insert(words.end(), more.begin(), more.end());
  return run_pled_vins(words);
}

void append_line(const fs::path& file, const std::string& line) {
  fs::permissions(file, fs::perms::owner_write, fs::perm_options::add);
  std::ofstream(file, std::ios::app) << line;
}

TEST_SUITE("apps.report") {
  TEST_CASE("the page's figures are those of evaluate, and its errors come to its ATE") {
    const RecordingCopy recording;
    REQUIRE(recording.replay().code == 0);
    const Outcome made = report(recording);
    REQUIRE_MESSAGE(made.code == 0, made.err);
    const fs::path page = recording.out() / "report.html";
    CHECK(made.out == page.string() + "\n");
    CHECK(made.err == "");
    const Outcome evaluated =
        run_pled_vins({"evaluate", (recording.out() / "trajectory.tum").string(),
                       (recording.path() / "groundtruth.txt").string(), "--json"});
    REQUIRE(evaluated.code == 0);
    const Json figures = Json::parse(evaluated.out);
    const Json run = run_of(page);
    for (const char* name : {"ate_rmse_m", "mpe_percent", "rpe_trans_m", "rpe_rot_deg"}) {
      CAPTURE(name);
      REQUIRE(figures[name].is_number());
      // The page keeps every digit, the command prints the nine that count.
      char nine[32];
      std::snprintf(nine, sizeof nine, "%.9g", run["accuracy"][name].get<double>());
      CHECK(std::stod(nine) == figures[name].get<double>());
    }
    CHECK(run["accuracy"]["coverage"].get<double>() ==
          doctest::Approx(figures["coverage"].get<double>()));
    double sum_m2 = 0.0;
    const Json& errors = run["trajectory"]["error_m"];
    REQUIRE(errors.size() == figures["poses"]["matched"]);
    for (const Json& error_m : errors) sum_m2 += error_m.get<double>() * error_m.get<double>();
    CHECK(std::sqrt(sum_m2 / static_cast<double>(errors.size())) ==
          doctest::Approx(figures["ate_rmse_m"].get<double>()).epsilon(1e-3));
  }

  TEST_CASE("the page is one file below 3 MB with pictures, events, features and rates in it") {
    const RecordingCopy recording;
    REQUIRE(recording.replay().code == 0);
    REQUIRE(report(recording).code == 0);
    const fs::path page = recording.out() / "report.html";
    CHECK(fs::file_size(page) < 3'000'000);
    const std::string text = bytes_of(page);
    CHECK(!contains(text, "http://"));
    CHECK(!contains(text, "https://"));
    CHECK(!contains(text, " src="));
    const Json run = run_of(page);
    const Json& moments = run["moments"]["list"];
    CHECK(moments.size() >= 12);
    CHECK(moments.size() <= 20);
    std::size_t events = 0;
    for (const Json& moment : moments) {
      CHECK(moment["frame"].get<std::string>().starts_with("iVBOR"));
      CHECK(!moment["features"].empty());
      events += moment["event_count"].get<std::size_t>();
    }
    CHECK(events > 0);
    CHECK(run["features"]["t_s"].size() == recording.lines("images.txt").size());
    for (const char* name : {"event_points", "event_points_used", "temporal_image",
                             "temporal_image_moving", "temporal_event", "temporal_event_moving"}) {
      CAPTURE(name);
      CHECK(run["features"][name].size() == run["features"]["t_s"].size());
    }
    CHECK(run["features"]["temporal_image"].back() > 0.5);  // nothing moves by itself
    CHECK(run["features"]["temporal_image_moving"].back().is_null());
    CHECK(run["rates"]["imu"]["per_s"][1] == 200);
    CHECK(run["rates"]["frames"]["per_s"][1] == 20);
    CHECK(run["rates"]["events"]["per_s"][1] > 0);
    CHECK(run["notes"].empty());
  }

  TEST_CASE("replay makes the page unless told not to, and leaves its settings and version") {
    const RecordingCopy recording;
    const std::string out = recording.out().string();
    const Outcome o =
        run_pled_vins({"replay", recording.path().string(), "--out", out, "--duration", "0.5"});
    REQUIRE_MESSAGE(o.code == 0, o.err);
    CHECK_MESSAGE(contains(o.out, "report.html"), o.out);
    const Json run = run_of(recording.out() / "report.html");
    CHECK(contains(run["report"]["version"].get<std::string>(), "0."));
    CHECK(run["config"] == bytes_of(recording.out() / "config.yaml"));
    CHECK(run_pled_vins({"config", "--print-default"}).out ==
          bytes_of(recording.out() / "config.yaml"));
    REQUIRE(recording.replay({"--duration", "0.5"}).code == 0);  // --no-report
    CHECK(!fs::exists(recording.out() / "report.html"));         // nor that of the run before
    CHECK(fs::exists(recording.out() / "config.yaml"));
  }

  TEST_CASE("a page that cannot be written is a warning after a good replay") {
    const RecordingCopy recording;
    fs::create_directories(recording.out() / "report.html.part" / "in the way");
    const Outcome o = run_pled_vins({"replay", recording.path().string(), "--out",
                                     recording.out().string(), "--duration", "0.3"});
    CHECK(o.code == 0);
    CHECK_MESSAGE(contains(o.err, "warning: no report was made: "), o.err);
    CHECK_MESSAGE(contains(o.err, "report.html"), o.err);
    CHECK(report(recording).code == 1);
  }

  TEST_CASE("without its recording a run still has a page, which says what is missing") {
    const RecordingCopy recording;
    REQUIRE(recording.replay().code == 0);
    const fs::path moved = recording.path().parent_path() / "moved";
    fs::rename(recording.path(), moved);
    const Outcome o = report(recording);
    REQUIRE_MESSAGE(o.code == 0, o.err);
    CHECK_MESSAGE(contains(o.err, "note: without pictures"), o.err);
    CHECK_MESSAGE(contains(o.err, recording.path().string()), o.err);
    const Json run = run_of(recording.out() / "report.html");
    CHECK(run["notes"].size() == 1);
    CHECK(run["truth"].is_null());
    CHECK(run["accuracy"]["ate_rmse_m"] == run["report"]["accuracy"]["ate_rmse_m"]);
    CHECK(!run["moments"]["list"][0].contains("frame"));
    CHECK(!run["moments"]["list"][0]["features"].empty());
    REQUIRE(report(recording, {"--recording", moved.string()}).code == 0);
    CHECK(run_of(recording.out() / "report.html")["truth"].is_object());
    fs::rename(moved, recording.path());
  }

  TEST_CASE("missing and broken results are named, with the line") {
    const RecordingCopy recording;
    REQUIRE(recording.replay({"--duration", "1"}).code == 0);
    const fs::path features = recording.out() / "features.csv";
    const std::string good = bytes_of(features);
    const std::string line = std::to_string(lines_of(features).size() + 1);
    append_line(features, "0.9,1,image_point,7\n");
    Outcome o = report(recording);
    CHECK(o.code == 1);
    CHECK_MESSAGE(contains(o.err, features.string() + ":" + line + ": has 4 columns"), o.err);
    CHECK(!fs::exists(recording.out() / "report.html"));
    std::ofstream(features, std::ios::binary) << good.substr(0, good.size() - 9);
    o = report(recording);
    CHECK(o.code == 1);
    CHECK_MESSAGE(contains(o.err, "cut off"), o.err);
    fs::remove(features);
    o = report(recording);
    CHECK(o.code == 0);
    CHECK_MESSAGE(contains(o.err, "without features and weights"), o.err);
    CHECK(run_of(recording.out() / "report.html")["features"].is_null());
    append_line(recording.out() / "trajectory.tum", "1.0 nonsense\n");
    o = report(recording);
    CHECK(o.code == 1);
    CHECK_MESSAGE(contains(o.err, "trajectory.tum:"), o.err);
    std::ofstream(recording.out() / "report.json") << "{\"schema\": ";
    o = report(recording);
    CHECK(o.code == 1);
    CHECK_MESSAGE(contains(o.err, "report.json: is not JSON"), o.err);
    fs::remove(recording.out() / "report.json");
    CHECK(report(recording).code == 1);
    CHECK(run_pled_vins({"report"}).code == 2);
    CHECK(run_pled_vins({"report", "--help"}).code == 0);
  }

  TEST_CASE("two runs stand side by side") {
    const RecordingCopy recording;
    REQUIRE(recording.replay().code == 0);
    const fs::path other = recording.out().parent_path() / "other";
    recording.write("my.yaml", "frontend:\n  max_points: 60\n");
    REQUIRE(run_pled_vins({"replay", recording.path().string(), "--out", other.string(), "--config",
                           (recording.path() / "my.yaml").string(), "--no-report"})
                .code == 0);
    const Outcome o = run_pled_vins({"compare", recording.out().string(), other.string()});
    REQUIRE_MESSAGE(o.code == 0, o.err);
    const fs::path page = other / "comparison.html";
    CHECK(o.out == page.string() + "\n");
    CHECK(fs::file_size(page) < 3'000'000);
    const Json runs = data_of(page)["runs"];
    REQUIRE(runs.size() == 2);
    CHECK(runs[0]["name"] == "out");
    CHECK(runs[1]["name"] == "other");
    CHECK(runs[0]["accuracy"]["ate_rmse_m"] != runs[1]["accuracy"]["ate_rmse_m"]);
    CHECK(contains(runs[1]["config"].get<std::string>(), "max_points: 60"));
    CHECK(run_pled_vins({"compare", recording.out().string()}).code == 2);
    CHECK(run_pled_vins({"compare", recording.out().string(), "/nowhere"}).code == 1);
  }

  TEST_CASE("a run that never started has a page too") {
    const RecordingCopy recording;
    REQUIRE(recording.replay({"--duration", "0.2"}).code == 0);
    const Outcome o = report(recording);
    CHECK_MESSAGE(o.code == 0, o.err);
    const Json run = run_of(recording.out() / "report.html");
    CHECK(run["trajectory"]["t_s"].empty());
    CHECK(run["accuracy"]["ate_rmse_m"].is_null());
  }
}

}  // namespace
