#include <numbers>

#include <doctest/doctest.h>

#include "drivers/replay/aedat2_header.hpp"
#include "unit/drivers/aedat2_writer.hpp"
#include "unit/drivers/aedat_reading.hpp"
#include "unit/drivers/recording_writer.hpp"

using namespace pled;
using namespace pled::replay;
using namespace pled::support;

namespace {

Aedat2Header header_of(const TemporaryFolder& folder, const std::string& head,
                       const Pairs& pairs = {{dvs(1, 1, true), 1}}) {
  write_file(folder / "a.aedat", aedat2_file(head, pairs));
  const auto header = read_aedat2_header((folder / "a.aedat").c_str());
  REQUIRE(header.ok());
  return header.value();
}

/// Events 1 ms apart, and an inertial sample after each.
Pairs some_records(unsigned count) {
  Pairs pairs;
  for (unsigned i = 0; i < count; ++i) {
    pairs.push_back({dvs(i % 240, i % 180, true), 1000 * i});
    add_imu(pairs, 1000 * i + 500, {4096, 0, 0, 0, 328, 0, 0});
  }
  return pairs;
}

std::string line(const std::string& text) { return "#" + text + "\r\n"; }

}  // namespace

TEST_SUITE("drivers.aedat2_file") {
  TEST_CASE("the header tells the chip, its size and the ranges of the inertial sensor") {
    const TemporaryFolder folder;
    const Aedat2Header header = header_of(folder, kAedat2Head);
    CHECK(header.bytes == static_cast<std::int64_t>(kAedat2Head.size()));
    CHECK(header.chip == "eu.seebetter.ini.chips.davis.DAVIS240C");
    CHECK(header.is_davis);
    CHECK(header.size == ImageSize{240, 180});
    CHECK(header.imu_is_known);
    CHECK(header.imu.gyro_degps == doctest::Approx(1.0 / 32.8));
    CHECK(header.imu.accel_g == doctest::Approx(1.0 / 4096.0));
    const Aedat2Header other = header_of(
        folder, line("!AER-DAT2.0") + line(" AEChip: eu.x.Davis346blue") +
                    line("<entry key=\"ImuGyroScale\" value=\"GyroFullScaleDegPerSec250\"/>") +
                    line("<entry key=\"ImuAccelScale\" value=\"ImuAccelScaleG16\"/>"));
    CHECK(other.size == ImageSize{346, 260});
    CHECK(other.imu.gyro_degps == doctest::Approx(1.0 / 131.2));
    CHECK(other.imu.accel_g == doctest::Approx(1.0 / 2048.0));
  }

  TEST_CASE("a header that tells less leaves the defaults, and one of another chip is told") {
    const TemporaryFolder folder;
    const Aedat2Header bare = header_of(folder, line("!AER-DAT2.0"));
    CHECK(bare.chip.empty());
    CHECK(bare.is_davis);
    CHECK(bare.size == ImageSize{});
    CHECK_FALSE(bare.imu_is_known);
    CHECK(bare.imu.gyro_degps == doctest::Approx(1.0 / 32.8));
    const Aedat2Header odd = header_of(
        folder, line("!AER-DAT2.0") + line(" AEChip: ch.unizh.ini.jaer.chip.retina.DVS128") +
                    line("<entry key=\"ImuGyroScale\" value=\"GyroFullScaleDegPerSec777\"/>"));
    CHECK_FALSE(odd.is_davis);
    CHECK(odd.imu.gyro_degps == doctest::Approx(1.0 / 32.8));
  }

  TEST_CASE("records that begin with the sign of a line are no part of the header") {
    const TemporaryFolder folder;
    const Pairs records{{0x23000800U, 0x0A000001U}, {0x23000800U, 0x0A000002U}};
    CHECK(header_of(folder, kAedat2Head, records).bytes ==
          static_cast<std::int64_t>(kAedat2Head.size()));
    const std::string marked = kAedat2Head + line("End Of ASCII Header");
    // A record whose bytes are all text, behind the marked end.
    const Pairs text{{0x23414141U, 0x4141410AU}};
    CHECK(header_of(folder, marked, text).bytes == static_cast<std::int64_t>(marked.size()));
  }

  TEST_CASE("a file gives its events and inertial samples on one clock") {
    const TemporaryFolder folder;
    write_file(folder / "a.aedat", aedat2_file(kAedat2Head, some_records(50)));
    Problems problems;
    const auto recording = Recording::open(folder / "a.aedat", problems);
    REQUIRE(recording.ok());
    CHECK(problems.empty());
    CHECK(recording.value().event_size() == ImageSize{240, 180});
    CHECK_FALSE(recording.value().has(Stream::kFrames));
    const Played got = play(recording.value());
    REQUIRE(got.events.size() == 50);
    CHECK(same(got.events[2], {{2000}, 237, 177, Polarity::kOn}));
    REQUIRE(got.imu.size() == 50);
    CHECK(got.imu[2].t.us == 2500);
    CHECK(got.imu[2].gyro_radps[0] == doctest::Approx(10.0 * std::numbers::pi / 180.0));
    const auto info = survey(recording.value(), problems, {});
    REQUIRE(info.ok());
    CHECK(info.value().events.count == 50);
    CHECK(info.value().imu.count == 50);
    CHECK(info.value().problems.empty());
  }

  TEST_CASE("frames come from the reads of each pixel; special events are counted") {
    const TemporaryFolder folder;
    const std::string head = line("!AER-DAT2.0") + line(" AEChip: eu.x.DAVIS128");
    Pairs pairs;
    std::uint32_t stamp = 0;
    for (unsigned frame = 0; frame < 2; ++frame) {
      pairs.push_back({special(), stamp});
      for (unsigned i = 0; i < 128 * 128; ++i)
        pairs.push_back({reset_read(i % 128, i / 128, 800), stamp++});
      for (unsigned i = 0; i < 128 * 128; ++i)
        pairs.push_back({signal_read(i % 128, i / 128, 800 - 4 * (i / 128)), stamp++});
    }
    write_file(folder / "a.aedat", aedat2_file(head, pairs));
    Problems problems;
    const auto recording = Recording::open(folder / "a.aedat", problems);
    REQUIRE(recording.ok());
    CHECK(recording.value().frame_size() == ImageSize{128, 128});
    const Played got = play(recording.value());
    REQUIRE(got.frames.size() == 2);
    CHECK(got.frames[1].t.us > got.frames[0].t.us);
    CHECK(got.pixels[0].front() == 127);  // the uppermost row is the last one of the file
    CHECK(got.pixels[0].back() == 0);
    const auto info = survey(recording.value(), problems, {});
    REQUIRE(info.ok());
    CHECK(info.value().frames.count == 2);
    CHECK(info.value().triggers.count == 2);
  }

  TEST_CASE("the size of an unknown DAVIS is that of the calibration") {
    const TemporaryFolder folder;
    Pairs pairs{{dvs(0, 0, true), 1}, {dvs(0, 0, true), 2}};
    for (unsigned i = 0; i < 6; ++i) pairs.push_back({reset_read(i % 3, i / 3, 9), 3 + i});
    for (unsigned i = 0; i < 6; ++i) pairs.push_back({signal_read(i % 3, i / 3, 5), 9 + i});
    write_file(folder / "a.aedat",
               aedat2_file(line("!AER-DAT2.0") + line(" AEChip: eu.x.DavisX"), pairs));
    Problems problems;
    auto recording = Recording::open(folder / "a.aedat", problems);
    REQUIRE(recording.ok());
    CHECK(recording.value().event_size() == ImageSize{});
    CHECK(recording.value().has(Stream::kFrames));
    const auto info = survey(recording.value(), problems, {});
    REQUIRE(info.ok());
    CHECK(says(info.value().problems, {"frames were not read", "size is not given"}));
    CHECK_FALSE(recording.value().set_frame_size({4, 2}));
    CHECK(recording.value().set_frame_size({3, 2}));
    recording.value().set_event_size({3, 2});
    const Played got = play(recording.value());
    CHECK(got.events.size() == 2);
    CHECK(got.events[0].x_px == 2);
    CHECK(got.frames.size() == 1);
  }

  TEST_CASE("a known chip contradicts a calibration of another size") {
    const TemporaryFolder folder;
    Pairs pairs;
    for (unsigned i = 0; i < 128 * 128; ++i) pairs.push_back({reset_read(i % 128, i / 128, 9), i});
    for (unsigned i = 0; i < 128 * 128; ++i)
      pairs.push_back({signal_read(i % 128, i / 128, 5), 20000 + i});
    write_file(folder / "a.aedat",
               aedat2_file(line("!AER-DAT2.0") + line(" AEChip: eu.x.DAVIS128"), pairs));
    Problems problems;
    auto recording = Recording::open(folder / "a.aedat", problems);
    REQUIRE(recording.ok());
    CHECK_FALSE(recording.value().set_frame_size({64, 64}));
    CHECK(recording.value().set_frame_size({128, 128}));
  }

  TEST_CASE("a chip with other addresses is refused, and unknown ranges are told") {
    const TemporaryFolder folder;
    Problems problems;
    write_file(folder / "a.aedat",
               aedat2_file(line("!AER-DAT2.0") + line(" AEChip: ch.x.DVS128"), some_records(2)));
    CHECK_FALSE(Recording::open(folder / "a.aedat", problems).ok());
    CHECK(says(problems, {"error", "ch.x.DVS128", "DAVIS"}));
    problems.clear();
    write_file(folder / "a.aedat",
               aedat2_file(line("!AER-DAT2.0") + line(" AEChip: a.DAVIS240C"), some_records(2)));
    CHECK(Recording::open(folder / "a.aedat", problems).ok());
    CHECK(says(problems, {"warning", "ranges of the IMU"}));
  }

  TEST_CASE("a file that is cut at any byte gives what stands before the cut") {
    const TemporaryFolder folder;
    const std::vector<std::byte> bytes = aedat2_file(kAedat2Head, some_records(6));
    std::size_t most = 0;
    for (std::size_t size = kAedat2Head.size(); size <= bytes.size(); ++size) {
      CAPTURE(size);
      write_file(folder / "a.aedat", std::span(bytes).first(size));
      Problems problems;
      const auto recording = Recording::open(folder / "a.aedat", problems);
      REQUIRE(recording.ok());
      const Played got = play(recording.value());
      const std::size_t items = got.events.size() + got.imu.size();
      CHECK(items >= most);
      most = items;
      const bool is_whole = (size - kAedat2Head.size()) % 8 == 0;
      CHECK(got.faults.malformed == (is_whole ? 0 : 1));
      CHECK(got.bad_samples <= 1);
    }
    CHECK(most == 12);
  }
}
