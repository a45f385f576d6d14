// Recordings that cannot be replayed: refused in words that name the file and the remedy.

#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/core/image_view.hpp"
#include "src/sim/png_file.hpp"
#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;
namespace fs = std::filesystem;

/// Checks that a replay fails with all these words and leaves no result.
void check_refused(const RecordingCopy& recording, const std::vector<std::string>& words) {
  const Outcome o = recording.replay();
  CHECK(o.code == 1);
  CHECK(o.out == "");
  CHECK_MESSAGE(contains(o.err, "pled-vins: error: "), o.err);
  for (const std::string& word : words)
    CHECK_MESSAGE(contains(o.err, word), "no '" << word << "' in: " << o.err);
  CHECK(!fs::exists(recording.out() / "trajectory.tum"));
}

/// Writes a grey image over a file of the recording.
void write_image(const RecordingCopy& recording, const std::string& name, int width, int height) {
  recording.remove(name);
  const std::vector<std::uint8_t> grey(static_cast<std::size_t>(width * height), 128);
  REQUIRE(pled::sim::write_png(recording.path() / name, {grey.data(), width, height, width}).ok());
}

TEST_SUITE("apps.replay_bad_files") {
  TEST_CASE("a folder that is not there is named") {
    const RecordingCopy recording;
    fs::remove_all(recording.path());
    check_refused(recording, {recording.path().string(), "no such folder"});
  }

  TEST_CASE("an empty folder is told from a recording, with the names that were looked for") {
    const RecordingCopy recording;
    fs::remove_all(recording.path());
    fs::create_directories(recording.path());
    check_refused(recording, {recording.path().string(), "images.txt", "imu.txt"});
  }

  TEST_CASE("each file that is needed is named when it is missing or empty") {
    for (const std::string name : {"images.txt", "imu.txt"}) {
      CAPTURE(name);
      const RecordingCopy recording;
      recording.remove(name);
      check_refused(recording, {name, "missing"});
      recording.write(name, "");
      check_refused(recording, {name, "empty"});
    }
    const RecordingCopy recording;
    recording.remove("camchain.yaml");
    check_refused(recording, {"camchain.yaml", "settings"});
    recording.remove("calib.txt");
    check_refused(recording, {"camchain.yaml", "settings"});
    const RecordingCopy other;
    other.remove("imu.yaml");
    check_refused(other, {"imu.yaml", "settings"});
  }

  TEST_CASE("lists without any usable line are refused, not replayed to nothing") {
    const RecordingCopy frames;
    frames.write("images.txt", "once upon\na time there was\n");
    check_refused(frames, {"images.txt"});
    const RecordingCopy pictures;
    fs::remove_all(pictures.path() / "images");
    check_refused(pictures, {"images.txt"});
  }

  TEST_CASE("a calibration that cannot be read is told with file, line and key") {
    const RecordingCopy recording;
    const std::string file = (recording.path() / "camchain.yaml").string();
    const std::string good = bytes_of(file);

    recording.write("camchain.yaml", "cam0: [\n");
    check_refused(recording, {file + ":", "not valid YAML"});

    recording.write("camchain.yaml", good);
    recording.replace("camchain.yaml", "[0, 0, 0, 1]", "[0, 0, 1]");
    check_refused(recording, {file + ":10: cam0.T_cam_imu"});

    recording.write("camchain.yaml", good);
    recording.replace("camchain.yaml", "- [0.99", "- [2.99");
    check_refused(recording, {file + ":", "cam0.T_cam_imu", "not orthonormal"});

    recording.write("camchain.yaml", good);
    recording.replace("camchain.yaml", "resolution:", "rezolution:");
    check_refused(recording, {file, "cam0.resolution"});

    recording.write("camchain.yaml", good);
    recording.replace("camchain.yaml", "timeshift_cam_imu: 0", "timeshift_cam_imu: soon");
    check_refused(recording, {file + ":11: cam0.timeshift_cam_imu", "'soon'"});

    recording.write("camchain.yaml", good);
    recording.replace("camchain.yaml", "timeshift_cam_imu: 0", "timeshift_cam_imu: 1e15");
    check_refused(recording, {file + ":11: cam0.timeshift_cam_imu", "[-1, 1] s"});

    recording.write("camchain.yaml", std::string("\0\1\2", 3));
    check_refused(recording, {file, "not a text file"});
  }

  TEST_CASE("frames of another size than the calibration's are refused with both sizes") {
    const RecordingCopy recording;
    recording.replace("camchain.yaml", "[240, 180]", "[346, 260]");
    check_refused(recording, {"240x180", "346x260", "resolution"});
  }

  TEST_CASE("a sensor larger than every class is refused with its size and the largest class") {
    const RecordingCopy recording;
    fs::remove(recording.path() / "events.raw");
    recording.set_lines("images.txt", {"0.1 images/frame_00000000.png"});
    write_image(recording, "images/frame_00000000.png", 1600, 1200);
    recording.replace("camchain.yaml", "[240, 180]", "[1600, 1200]");
    check_refused(recording, {"1600x1200", "hd", "1280x720"});
  }

  TEST_CASE("stamps in another unit are refused with both spans, not run to no pose") {
    const auto in_other_unit = [](std::vector<std::string> lines, double factor) {
      for (std::string& line : lines) {
        const std::size_t end = line.find(' ');
        line = std::to_string(std::stod(line) * factor) + line.substr(end);
      }
      return lines;
    };
    for (const double factor : {1e3, 1e6, 1e9}) {
      CAPTURE(factor);
      for (const std::string name : {"images.txt", "imu.txt"}) {
        CAPTURE(name);
        const RecordingCopy recording;
        recording.set_lines(name, in_other_unit(recording.lines(name), factor));
        check_refused(recording, {"images.txt covers ", "imu.txt covers ", "overlap",
                                  "stamps must be seconds on one clock"});
      }
    }
    const RecordingCopy later;
    std::vector<std::string> lines = later.lines("imu.txt");
    for (std::string& line : lines)
      line = std::to_string(std::stod(line) + 1.7e9) + line.substr(line.find(' '));
    later.set_lines("imu.txt", lines);
    check_refused(later, {"no overlap"});
    const RecordingCopy kept;
    REQUIRE(kept.replay({"--duration", "0.2"}).code == 0);
    kept.set_lines("imu.txt", in_other_unit(kept.lines("imu.txt"), 1e9));
    CHECK(kept.replay().code == 1);
    CHECK(fs::exists(kept.out() / "report.json"));  // --force removes nothing before a run can be
    const RecordingCopy unreadable;
    unreadable.write("imu.txt", "1403715273262142976000 0 0 9.81 0 0 0\n");
    check_refused(unreadable, {"imu.txt", "no sample that can be read", "line 1"});
  }

  TEST_CASE("an output folder that cannot be made is refused, and its neighbour left as it is") {
    const RecordingCopy recording;
    const std::string file = (recording.path() / "imu.txt").string();
    const std::string before = bytes_of(file);
    const Outcome below =
        run_pled_vins({"replay", recording.path().string(), "--out", file + "/x"});
    CHECK(below.code == 1);
    CHECK_MESSAGE(contains(below.err, file + "/x"), below.err);
    const Outcome onto =
        run_pled_vins({"replay", recording.path().string(), "--out", file, "--force"});
    CHECK(onto.code == 1);
    CHECK_MESSAGE(contains(onto.err, "not a folder"), onto.err);
    CHECK(bytes_of(file) == before);
  }

  TEST_CASE("events in a format that is not read are refused, not passed over") {
    const RecordingCopy recording;
    recording.write("events.raw", "% evt 2.0\n% end\n1234");
    check_refused(recording, {"events.raw", "EVT2", "EVT3"});
  }
}

}  // namespace
