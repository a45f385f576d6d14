// The main job on recordings that are not part of the repository: PLED_RECORDINGS names their
// folder.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;
namespace fs = std::filesystem;

/// A recording below PLED_RECORDINGS; nothing, with a message, when it is not there.
std::optional<fs::path> recording(const std::string& name) {
  const char* folder = std::getenv("PLED_RECORDINGS");
  if (folder == nullptr) {
    MESSAGE("skipped " << name << ": PLED_RECORDINGS is not set");
    return std::nullopt;
  }
  if (fs::is_directory(fs::path(folder) / name)) return fs::path(folder) / name;
  MESSAGE("skipped " << name << ": not in PLED_RECORDINGS");
  return std::nullopt;
}

struct Run {
  nlohmann::json report;
  std::vector<TumPose> poses;
};

Run replay(const fs::path& folder, const std::vector<std::string>& more = {}) {
  const fs::path out = fs::path(PLED_TEST_FOLDER) / ("results-" + folder.filename().string());
  std::vector<std::string> words{"replay",     folder.string(), "--out",
                                 out.string(), "--force",       "--no-report"};
  words.insert(words.end(), more.begin(), more.end());
  const Outcome o = run_pled_vins(words);
  REQUIRE_MESSAGE(o.code == 0, o.err);
  Run run{nlohmann::json::parse(bytes_of(out / "report.json")), read_tum(out / "trajectory.tum")};
  fs::remove_all(out);
  REQUIRE(!run.poses.empty());
  return run;
}

double distance_m(const TumPose& a, const TumPose& b) {
  return std::hypot(a.p[0] - b.p[0], a.p[1] - b.p[1], a.p[2] - b.p[2]);
}

TEST_SUITE("apps.replay_recordings") {
  TEST_CASE("a drone that stands still is started and stays within 2 cm of its first pose") {
    const auto folder = recording("real/euroc_v101_start");
    if (!folder) return;
    // The motors start after half a second: a start before, within and after must hold.
    for (const std::string start_s : {"0", "0.1", "0.2", "0.3", "0.5", "0.8", "1.2"}) {
      CAPTURE(start_s);
      const Run run = replay(*folder, {"--start", start_s});
      const double farthest_m = farthest_from_first_m(run.poses);
      MESSAGE("started after " << run.report["initialised_at_s"] << " s, " << run.poses.size()
                               << " poses, at most " << 1e3 * farthest_m << " mm away");
      CHECK(run.report["resets"] == 0);
      CHECK(farthest_m < 0.02);
    }
  }

  TEST_CASE("a hand-held walk round a room is survived to its end without a jump") {
    const auto folder = recording("real/room_handheld");
    if (!folder) return;
    const Run run = replay(*folder);
    const double end_s = run.poses.front().t_s - run.report["initialised_at_s"].get<double>() +
                         run.report["duration_s"].get<double>();
    double longest_step_m = 0.0;
    double top_speed_mps = 0.0;
    for (std::size_t i = 1; i < run.poses.size(); ++i) {
      const double step_m = distance_m(run.poses[i - 1], run.poses[i]);
      longest_step_m = std::max(longest_step_m, step_m);
      top_speed_mps = std::max(top_speed_mps, step_m / (run.poses[i].t_s - run.poses[i - 1].t_s));
    }
    MESSAGE("started after " << run.report["initialised_at_s"] << " s, longest step "
                             << longest_step_m << " m, top speed " << top_speed_mps << " m/s, "
                             << run.report["resets"] << " resets");
    CHECK(run.report["duration_s"] > 23.0);
    CHECK(run.poses.back().t_s > end_s - 0.2);
    CHECK(longest_step_m < 0.5);
    CHECK(top_speed_mps < 5.0);
  }

  TEST_CASE("every simulated recording starts within 3 s, the room within 1.5 s") {
    for (const std::string name :
         {"parking_none", "parking_high", "city_night_high", "room_6dof"}) {
      const auto folder = recording("simulated/" + name);
      if (!folder) continue;
      CAPTURE(name);
      const Run run = replay(*folder, {"--duration", "4"});
      MESSAGE(name << " started after " << run.report["initialised_at_s"] << " s");
      CHECK(run.report["initialised_at_s"] < (name == "room_6dof" ? 1.5 : 3.0));
    }
  }
}

}  // namespace
