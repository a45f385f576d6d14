// pled-vins simulate as its users type it.

#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;
namespace fs = std::filesystem;

/// A new folder of this name, empty.
fs::path fresh(const std::string& name) {
  const fs::path folder = fs::path(PLED_TEST_FOLDER) / ("simulate-" + name);
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  fs::create_directories(folder.parent_path());
  return folder;
}

/// A TUM file that walks `length_m` along x in `duration_s`.
fs::path walk(const std::string& name, double length_m, double duration_s) {
  const fs::path file = fresh(name);
  std::ofstream out(file);
  for (int k = 0; k <= 50; ++k)
    out << duration_s * k / 50.0 << ' ' << length_m * k / 50.0 << " 0 0 -0.5 0.5 -0.5 0.5\n";
  return file;
}

struct Refusal {
  std::vector<std::string> arguments;
  int code;
  std::string words;
};

void check_refused(const Refusal& refusal, const fs::path& out) {
  std::vector<std::string> all{"simulate"};
  all.insert(all.end(), refusal.arguments.begin(), refusal.arguments.end());
  const Outcome o = run_pled_vins(all);
  CAPTURE(refusal.words);
  CHECK(o.code == refusal.code);
  CHECK_MESSAGE(contains(o.err, refusal.words), o.err);
  CHECK_FALSE(fs::exists(out / "imu.txt"));
}

}  // namespace

TEST_SUITE("apps.simulate") {
  TEST_CASE("a recording of two cameras replays as it is, by its own settings") {
    const fs::path recording = fresh("two"), out = fresh("two-out");
    const Outcome made = run_pled_vins({"simulate", "--preset", "still", "--duration", "0.3",
                                        "--second-camera", "--out", recording.string()});
    REQUIRE_MESSAGE(made.code == 0, made.err);
    const Outcome o =
        run_pled_vins({"replay", recording.string(), "--out", out.string(), "--no-report"});
    CHECK_MESSAGE(o.code == 0, o.err);
    CHECK(contains(o.err, "settings.yaml; --config names others"));
    const auto report = nlohmann::json::parse(bytes_of(out / "report.json"));
    CHECK(report["faults"].empty());
    CHECK(report["events"]["in"] > 0);
    CHECK(run_pled_vins({"info", recording.string()}).out.find("346 x 260") != std::string::npos);
  }

  TEST_CASE("what cannot be is refused with the name of the option and the fix") {
    const fs::path out = fresh("refused");
    const std::string to = out.string();
    for (const Refusal& r : std::vector<Refusal>{
             {{"--out", ""}, 2, "--out is empty"},
             {{"--out", to, "--moving", "HIGH"}, 2, "none,low,mid,high"},
             {{"--out", to, "--moving", "2"}, 2, "none,low,mid,high"},
             {{"--out", to, "--duration", "0"}, 2, "--duration must be in"},
             {{"--out", to, "--camera-late", "0.5"}, 2, "--camera-late must be in"},
             {{"--out", to, "--drop-frames", "1"}, 2, "--drop-frames must be in"},
             {{"--out", to, "--speed", "3"}, 2, "--motion car"},
             {{"--out", to, "--preset", "room", "--motion", "car"}, 2, "--preset street"},
             {{"--out", to, "--surfaces", "dotted"}, 2, "usual,pebbles,stripes"},
             {{"--out", to, "--bus", "99", "0", "2"}, 2, "--bus must come in the recording"},
             {{"--out", to, "--bus", "3", "-1", "2"}, 2, "--bus must come and stand"},
             {{"--out", to, "--bus", "3", "0", "0.5"}, 2, "--bus must be in [1, 20] m away"},
             {{"--out", to, "--preset", "room", "--bus", "3", "0", "2"}, 2, "needs a road"},
             {{"--out", to, "--flash", "99"}, 2, "--flash must be in the recording"},
             {{"--out", to, "--flash", "-3"}, 2, "--flash must be in the recording"},
             {{"--out", to, "--imu-gap", "50", "1"}, 2, "--imu-gap must begin"},
             {{"--out", to, "--imu-gap", "0", "99"}, 2, "no inertial sample"}})
      check_refused(r, out);
  }

  TEST_CASE("a path that cannot be followed is refused with file, line and reason") {
    const fs::path out = fresh("path");
    const std::string to = out.string();
    const fs::path broken = walk("broken.tum", 1.0, 2.0);
    std::ofstream(broken, std::ios::app) << "1.0 0 0 0 0 0 0 1\n";  // back in time, line 52
    const fs::path brief = walk("brief.tum", 1.0, 1.0);
    const fs::path wide = walk("wide.tum", 40.0, 20.0);
    for (const Refusal& r : std::vector<Refusal>{
             {{"--out", to, "--path", to + ".none"}, 1, ".none: cannot be read"},
             {{"--out", to, "--path", broken.string()}, 1, "broken.tum:52: "},
             {{"--out", to, "--preset", "room", "--path", brief.string(), "--duration", "1.4"},
              1,
              "is 1.000 s long"},
             {{"--out", to, "--preset", "room", "--path", brief.string(), "--motion", "hand"},
              2,
              "leave out --motion"},
             {{"--out", to, "--preset", "room", "--path", wide.string()}, 1, "meets a wall"}})
      check_refused(r, out);
  }

  TEST_CASE("without a duration a path is followed to its end") {
    const fs::path out = fresh("whole-path");
    const fs::path path = walk("whole.tum", 0.3, 0.6);
    const Outcome o = run_pled_vins(
        {"simulate", "--preset", "room", "--path", path.string(), "--out", out.string()});
    REQUIRE_MESSAGE(o.code == 0, o.err);
    CHECK(contains(o.out, "0.600 s, 0.3"));
    CHECK(lines_of(out / "imu.txt").size() == 121);
  }

  TEST_CASE("nothing but a recording is replaced, and of its folder only what is its own") {
    const fs::path other = fresh("other");
    fs::create_directories(other / "images");
    std::ofstream(other / "images" / "holiday.png") << "x";
    const std::vector<std::string> still{"simulate", "--preset", "still", "--duration", "0.1"};
    const auto to = [&](const fs::path& folder) {
      std::vector<std::string> arguments = still;
      arguments.insert(arguments.end(), {"--out", folder.string(), "--force"});
      return run_pled_vins(arguments);
    };
    const Outcome refused = to(other);
    CHECK(refused.code == 1);
    CHECK(contains(refused.err, "something else than a recording"));
    const fs::path own = fresh("own");
    REQUIRE(to(own).code == 0);
    std::ofstream(own / "images" / "holiday.png") << "x";
    REQUIRE(to(own).code == 0);
    CHECK(fs::exists(own / "images" / "holiday.png"));
    const fs::path file = fresh("file");
    std::ofstream(file) << "x";
    const Outcome on_file = to(file);
    CHECK(on_file.code == 1);
    CHECK(contains(on_file.err, "is not a folder"));
  }
}
