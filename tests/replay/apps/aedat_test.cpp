#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <doctest/doctest.h>

#include "drivers/replay/recording.hpp"
#include "tests/support/recording_fixture.hpp"
#include "unit/drivers/aedat4_writer.hpp"

using namespace pled;
using namespace pled::support;
namespace fs = std::filesystem;

namespace {

float in_unit(double value, double unit) { return static_cast<float>(value / unit); }

std::vector<ImuRow> samples_of(const replay::Recording& recording) {
  constexpr double kGravity_mps2 = 9.80665;
  constexpr double kDegree_rad = 3.14159265358979323846 / 180.0;
  std::vector<ImuRow> rows;
  replay::Problems problems;
  auto source = recording.open_imu(problems);
  REQUIRE(source.ok());
  for (auto sample = source.value()->read({}); sample.ok(); sample = source.value()->read({})) {
    ImuRow row{sample.value().t.us, {}, {}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      row.accel_g[axis] = in_unit(sample.value().accel_mps2[axis], kGravity_mps2);
      row.gyro_degps[axis] = in_unit(sample.value().gyro_radps[axis], kDegree_rad);
    }
    rows.push_back(row);
  }
  return rows;
}

std::vector<FrameRow> frames_of(const replay::Recording& recording) {
  std::vector<FrameRow> rows;
  replay::Problems problems;
  auto source = recording.open_frames(1, problems);
  REQUIRE(source.ok());
  for (auto frame = source.value()->acquire({}); frame.ok(); frame = source.value()->acquire({})) {
    const auto& image = frame.value().image;
    FrameRow& row = rows.emplace_back();
    row.t_us = frame.value().t.us;
    row.width = image.width;
    row.height = image.height;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) row.pixels.push_back(image.at(y, x));
    source.value()->release();
  }
  return rows;
}

/// The frames and samples of a recording in the RPG layout, and two events a frame.
void write_as_aedat4(const fs::path& from, const fs::path& to) {
  replay::Problems problems;
  const auto recording = replay::Recording::open(from.string(), problems);
  REQUIRE(recording.ok());
  const auto size = recording.value().frame_size();
  Aedat4File file(
      {.compression = can_pack(1) ? 1 : 0, .width = size.width_px, .height = size.height_px});
  std::vector<ImuRow> samples = samples_of(recording.value());
  std::size_t next = 0;
  for (const FrameRow& frame : frames_of(recording.value())) {
    std::vector<ImuRow> before;
    while (next < samples.size() && samples[next].t_us <= frame.t_us)
      before.push_back(samples[next++]);
    const std::vector<Event> events(2, {{frame.t_us}, 5, 6, Polarity::kOn});
    file.add(2, imu_packet(before)).add(0, events_packet(events)).add(1, frame_packet(frame));
  }
  const Bytes bytes = file.bytes();
  std::ofstream(to, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

TEST_SUITE("apps.aedat") {
  TEST_CASE("an AEDAT 4 file beside its calibration is played like the folder it was made from") {
    const RecordingCopy copy;
    // The file gets two events a frame, so only what frames show is compared.
    const Outcome as_folder = copy.replay({"--no-events"});
    REQUIRE(as_folder.code == 0);
    const std::vector<TumPose> expected = read_tum(copy.out() / "trajectory.tum");
    REQUIRE(expected.size() > 10);

    const fs::path file = copy.path() / "walk.aedat4";
    write_as_aedat4(copy.path(), file);
    const Outcome info = run_pled_vins({"info", file.string()});
    CHECK(info.code == 0);
    CHECK(contains(info.out, "problems  none"));
    const Outcome as_file = run_pled_vins({"replay", file.string(), "--out", copy.out().string(),
                                           "--force", "--no-report", "--no-events"});
    CAPTURE(as_file.err);
    REQUIRE(as_file.code == 0);
    const std::vector<TumPose> poses = read_tum(copy.out() / "trajectory.tum");
    // The file has single precision where the folder has text, and microseconds.
    REQUIRE(poses.size() == expected.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      CHECK(poses[i].t_s == doctest::Approx(expected[i].t_s).epsilon(1e-6));
      for (std::size_t axis = 0; axis < 3; ++axis)
        CHECK(std::abs(poses[i].p[axis] - expected[i].p[axis]) < 0.02);
    }
    CHECK(contains(bytes_of(copy.out() / "report.json"), "\"events\""));

    // A file without its calibration says what it lacks.
    const fs::path alone = copy.out() / "alone.aedat4";
    fs::copy_file(file, alone);
    const Outcome refused =
        run_pled_vins({"replay", alone.string(), "--out", copy.out().string(), "--force"});
    CHECK(refused.code == 1);
    CHECK(contains(refused.err, "camchain.yaml"));
  }
}
