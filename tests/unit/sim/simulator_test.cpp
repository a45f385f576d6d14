#include "pled_vins/sim/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <sched.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include "drivers/decode/evt3_decoder.hpp"

namespace fs = std::filesystem;
using namespace pled;
using namespace pled::sim;

namespace {

/// A folder of its own under the system's temporary one, removed at the end.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const std::string& name)
      : path_(fs::temp_directory_path() / ("pled_sim_" + std::to_string(getpid()) + "_" + name)) {
    fs::remove_all(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::map<std::string, std::string> all_files(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const fs::directory_entry& e : fs::recursive_directory_iterator(folder))
    if (e.is_regular_file()) files[fs::relative(e.path(), folder).string()] = content(e.path());
  return files;
}

std::size_t lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

SimulationOptions brief() {
  SimulationOptions options = *preset("room");
  options.duration_s = 0.2;
  return options;
}

}  // namespace

TEST_SUITE("sim.simulator") {
  TEST_CASE("the recording layout is complete and its parts have the lengths they should") {
    const TemporaryFolder out{"layout"};
    double last_share = -1.0;
    bool grows = true;
    const auto result = simulate(brief(), out.path(), [&](double share) {
      grows = grows && share >= last_share;
      last_share = share;
    });
    REQUIRE(result.ok());
    CHECK(grows);
    CHECK(last_share == doctest::Approx(1.0));
    const SimulationSummary& s = result.value();
    const auto files = all_files(out.path());
    CHECK(s.frames == 4);  // 0, 50, 100, 150 ms
    CHECK(lines(files.at("images.txt")) == 4);
    CHECK(lines(files.at("masks.txt")) == 4);
    CHECK(lines(files.at("imu.txt")) == 41);  // both ends of 0.2 s at 200 Hz
    CHECK(lines(files.at("groundtruth.txt")) == 41);
    CHECK(
        files.at("images.txt").starts_with("0.000000000 images/frame_00000000.png\n0.050000000 "));
    CHECK(files.at("images/frame_00000003.png").starts_with("\x89PNG"));
    CHECK(files.at("masks/mask_00000003.png").starts_with("\x89PNG"));
    CHECK(files.at("calib.txt") ==
          "199.092 198.829 132.192 110.713 -0.36844 0.15095 -0.000296 -0.000759 0\n");
    CHECK(files.at("camchain.yaml").find("resolution: [240, 180]") != std::string::npos);
    CHECK(files.at("imu.yaml").find("update_rate: 200") != std::string::npos);
    CHECK(lines(files.at("states.csv")) == 42);
    CHECK(files.size() == 9 + 2 * 4);
  }

  TEST_CASE("the event file decodes to the events counted, in order and within the flight") {
    const TemporaryFolder out{"events"};
    const auto result = simulate(brief(), out.path());
    REQUIRE(result.ok());
    const std::string raw = content(out.path() / "events.raw");
    const std::size_t body = raw.find("% end\n") + 6;
    const auto bytes = std::as_bytes(std::span(raw)).subspan(body);
    Evt3Decoder decoder{240, 180};
    std::vector<Event> events(result.value().events + EventDecoder::kMinOutput);
    const DecodeStep step = decoder.decode(bytes, events);
    CHECK(step.bytes_consumed == bytes.size());
    REQUIRE(step.events == result.value().events);
    REQUIRE(step.events > 10000);
    CHECK(decoder.faults().time_backwards == 0);
    CHECK(decoder.faults().outside_sensor == 0);
    CHECK(events.front().t.us >= 0);
    CHECK(events[step.events - 1].t.us <= 200000);
    CHECK(events[step.events - 1].t.us > 195000);
  }

  TEST_CASE("events as text are those of the RAW file, and what is not written any more is gone") {
    const TemporaryFolder raw{"raw"}, text{"text"};
    SimulationOptions options = brief();
    options.duration_s = 0.1;
    options.event_camera = camera_beside(options.camera);
    options.with_depth = true;
    REQUIRE(simulate(options, text.path()).ok());
    options.event_camera.reset();
    options.with_depth = false;
    const auto made = simulate(options, raw.path());
    REQUIRE(made.ok());
    options.text_events = true;
    REQUIRE(simulate(options, text.path()).ok());
    for (const char* name : {"events.raw", "settings.yaml", "depth.txt", "depths"}) {
      CAPTURE(name);
      CHECK_FALSE(fs::exists(text.path() / name));
    }
    const std::string bytes = content(raw.path() / "events.raw");
    Evt3Decoder decoder{240, 180};
    std::vector<Event> events(made.value().events + EventDecoder::kMinOutput);
    const auto body = std::as_bytes(std::span(bytes)).subspan(bytes.find("% end\n") + 6);
    REQUIRE(decoder.decode(body, events).events == made.value().events);
    std::istringstream lines(content(text.path() / "events.txt"));
    for (std::size_t i = 0; i < made.value().events; ++i) {
      double t_s = 0.0;
      int x = 0, y = 0, p = 0;
      lines >> t_s >> x >> y >> p;
      REQUIRE(std::llround(t_s * 1e6) == events[i].t.us);
      REQUIRE(x == events[i].x_px);
      REQUIRE(y == events[i].y_px);
      REQUIRE((p == 1) == (events[i].polarity == Polarity::kOn));
    }
    std::string rest;
    lines >> rest;
    CHECK(rest.empty());
  }

  TEST_CASE("the same seed gives the same bytes and another seed another recording") {
    const TemporaryFolder a{"a"}, b{"b"}, c{"c"};
    SimulationOptions options = brief();
    options.duration_s = 0.1;
    REQUIRE(simulate(options, a.path()).ok());
    REQUIRE(simulate(options, b.path()).ok());
    options.seed = 2;
    REQUIRE(simulate(options, c.path()).ok());
    const auto files = all_files(a.path());
    CHECK((files == all_files(b.path())));
    const auto other = all_files(c.path());
    for (const char* name :
         {"events.raw", "imu.txt", "groundtruth.txt", "images/frame_00000001.png"})
      CHECK_MESSAGE(files.at(name) != other.at(name), name);
  }

  TEST_CASE("the number of processors changes no byte") {
    const TemporaryFolder a{"all"}, b{"one"};
    SimulationOptions options = brief();
    options.duration_s = 0.1;
    options.moving = MovingLevel::kHigh;
    REQUIRE(simulate(options, a.path()).ok());
    cpu_set_t before, one;
    REQUIRE(sched_getaffinity(0, sizeof before, &before) == 0);
    CPU_ZERO(&one);
    for (std::size_t cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++cpu)
      if (CPU_ISSET(cpu, &before)) CPU_SET(cpu, &one);
    REQUIRE(sched_setaffinity(0, sizeof one, &one) == 0);
    const bool written = simulate(options, b.path()).ok();
    REQUIRE(sched_setaffinity(0, sizeof before, &before) == 0);
    REQUIRE(written);
    CHECK((all_files(a.path()) == all_files(b.path())));
  }

  TEST_CASE("two cameras, depth and every fault come out as asked for") {
    const TemporaryFolder plain{"plain"}, out{"faults"};
    SimulationOptions options = brief();
    options.duration_s = 0.5;
    REQUIRE(simulate(options, plain.path()).ok());
    options.event_camera = camera_beside(options.camera);
    options.with_depth = true;
    options.faults.camera_late_s = 0.03;
    options.faults.imu_gap_at_s = 0.2;
    options.faults.imu_gap_s = 0.1;
    options.faults.imu_drift_ppm = 200.0;
    options.faults.dropped_share = 0.5;
    options.faults.flash_at_s = 0.3;
    const auto result = simulate(options, out.path());
    REQUIRE(result.ok());
    const auto good = all_files(plain.path());
    const auto files = all_files(out.path());
    CHECK(files.at("groundtruth.txt") == good.at("groundtruth.txt"));
    CHECK(files.at("settings.yaml").find("event_camera: cam1") != std::string::npos);
    CHECK(files.at("camchain.yaml").find("resolution: [346, 260]") != std::string::npos);
    CHECK(files.at("events.raw").find("% geometry 346x260\n") != std::string::npos);
    CHECK(lines(files.at("imu.txt")) == 101 - 20);
    CHECK(files.at("imu.txt").find("0.500100000 ") != std::string::npos);  // 200 ppm of 0.5 s
    CHECK(lines(files.at("images.txt")) == lines(files.at("depth.txt")));
    CHECK(lines(files.at("images.txt")) < 10);
    for (std::istringstream list(files.at("images.txt")); list;) {
      double stamp_s = 0.03;
      std::string name;
      if (list >> stamp_s >> name) CHECK(files.count(name) == 1);
      CHECK(std::abs(std::remainder(stamp_s - 0.03, 0.05)) < 1e-9);
    }
    const std::string& list = files.at("depth.txt");
    const std::string& png = files.at(list.substr(12, list.find('\n') - 12));
    CHECK(static_cast<int>(png[24]) == 16);      // bit depth, 25th byte of a PNG
    CHECK(result.value().events > 346U * 260U);  // the flash alone
  }

  TEST_CASE("pictures of a longer recording do not stay behind") {
    const TemporaryFolder out{"again"};
    SimulationOptions options = brief();
    REQUIRE(simulate(options, out.path()).ok());
    options.duration_s = 0.1;
    REQUIRE(simulate(options, out.path()).ok());
    CHECK(fs::exists(out.path() / "images/frame_00000001.png"));
    CHECK_FALSE(fs::exists(out.path() / "images/frame_00000002.png"));
    CHECK_FALSE(fs::exists(out.path() / "masks/mask_00000003.png"));
  }

  TEST_CASE("a folder that cannot be made and options out of range are errors") {
    const TemporaryFolder out{"refused"};
    fs::create_directories(out.path());
    std::ofstream(out.path() / "file") << "in the way";
    const auto blocked = simulate(brief(), out.path() / "file" / "recording");
    REQUIRE_FALSE(blocked.ok());
    CHECK(blocked.error().code == ErrorCode::kIoFailure);
    SimulationOptions options = brief();
    options.duration_s = -1.0;
    const auto refused = simulate(options, out.path() / "never");
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::kInvalidArgument);
    CHECK_FALSE(fs::exists(out.path() / "never"));
  }
}
