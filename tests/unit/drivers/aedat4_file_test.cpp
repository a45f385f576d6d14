#include <doctest/doctest.h>

#include "drivers/replay/aedat4_sources.hpp"
#include "unit/drivers/aedat4_writer.hpp"
#include "unit/drivers/aedat_reading.hpp"
#include "unit/drivers/recording_writer.hpp"

using namespace pled;
using namespace pled::replay;
using namespace pled::support;

namespace {

constexpr int kWidth = 20;
constexpr int kHeight = 10;
constexpr std::int64_t kBegin_us = 1'605'537'493'718'345;

std::vector<Event> some_events(std::int64_t begin_us, int count) {
  std::vector<Event> events;
  for (int i = 0; i < count; ++i)
    events.push_back({{begin_us + 5 * i},
                      static_cast<std::uint16_t>(i % kWidth),
                      static_cast<std::uint16_t>(i % kHeight),
                      i % 3 == 0 ? Polarity::kOn : Polarity::kOff});
  return events;
}

FrameRow some_frame(std::int64_t t_us, int width = kWidth, int height = kHeight) {
  FrameRow row{t_us, t_us - 50, t_us + 50, 0, width, height, {}};
  row.pixels = pattern(width, height);
  return row;
}

/// Two packets of each kind.
Aedat4File whole_file(Aedat4File::Options options) {
  Aedat4File file(std::move(options));
  for (const std::int64_t step_us : {0, 20'000}) {
    const std::int64_t t_us = kBegin_us + step_us;
    file.add(0, events_packet(some_events(t_us, 3000)))
        .add(3, triggers_packet(2))
        .add(1, frame_packet(some_frame(t_us + 500)))
        .add(2, imu_packet({{t_us, {0, -1, 0}, {1, 0, 0}}, {t_us + 1000, {0, -1, 0}, {2, 0, 0}}}));
  }
  return file;
}

Result<Recording> opened(const std::string& path, Problems& problems) {
  return Recording::open(path, problems);
}

RecordingInfo surveyed(const Recording& recording) {
  Problems problems;
  const auto info = survey(recording, problems, {});
  REQUIRE(info.ok());
  return info.value();
}

/// What a file with these bytes gives; it must open.
Played played(const Bytes& bytes) {
  const TemporaryFolder folder;
  write_file(folder / "a.aedat4", bytes);
  Problems problems;
  const auto recording = opened(folder / "a.aedat4", problems);
  REQUIRE(recording.ok());
  return play(recording.value());
}

}  // namespace

TEST_SUITE("drivers.aedat4_file") {
  TEST_CASE("a file gives its events, samples and frames, whichever way it is packed") {
    for (const int compression : {0, 1, 3}) {
      CAPTURE(compression);
      if (!can_pack(compression)) {
        MESSAGE("skipped, the library is missing: compression " << compression);
        continue;
      }
      const TemporaryFolder folder;
      write_file(folder / "a.aedat4", whole_file({.compression = compression}).bytes());
      Problems problems;
      const auto recording = opened(folder / "a.aedat4", problems);
      REQUIRE(recording.ok());
      CHECK(problems.empty());
      CHECK(recording.value().layout() == Layout::kAedat);
      CHECK(recording.value().event_size() == ImageSize{kWidth, kHeight});
      CHECK(recording.value().frame_size() == ImageSize{kWidth, kHeight});
      const Played got = play(recording.value());
      auto events = some_events(kBegin_us, 3000);
      const auto more = some_events(kBegin_us + 20'000, 3000);
      events.insert(events.end(), more.begin(), more.end());
      CHECK(same(got.events, events));
      REQUIRE(got.imu.size() == 4);
      CHECK(got.imu[1].t.us == kBegin_us + 1000);
      CHECK(got.imu[1].accel_mps2[1] == doctest::Approx(-9.80665));
      REQUIRE(got.frames.size() == 2);
      CHECK(got.frames[1].t.us == kBegin_us + 20'500);
      CHECK(got.frames[1].stamp_ns == (kBegin_us + 20'500) * 1000);
      CHECK(got.pixels[1] == pattern(kWidth, kHeight));
      CHECK(recording.value().frame_stamps_ns() ==
            std::vector<std::int64_t>{got.frames[0].stamp_ns, got.frames[1].stamp_ns});
      const RecordingInfo info = surveyed(recording.value());
      CHECK(info.events.count == 6000);
      CHECK(info.imu.count == 4);
      CHECK(info.frames.count == 2);
      CHECK(info.triggers.count == 4);
      CHECK(info.problems.empty());
    }
  }

  TEST_CASE("a chunk holds at most kChunkBytes, and a held packet is not overwritten") {
    const TemporaryFolder folder;
    write_file(folder / "a.aedat4", whole_file({}).bytes());
    Problems problems;
    const auto recording = opened(folder / "a.aedat4", problems);
    REQUIRE(recording.ok());
    auto events = recording.value().open_events(problems);
    REQUIRE(events.ok());
    auto& source = *events.value().source;
    CHECK(source.acquire({}).error().code == ErrorCode::kEndOfStream);  // not started
    REQUIRE(source.start().ok());
    std::size_t chunks = 0;
    std::size_t bytes = 0;
    for (auto chunk = source.acquire({}); chunk.ok(); chunk = source.acquire({})) {
      CHECK(chunk.value().bytes.size() <= limits::kChunkBytes);
      bytes += chunk.value().bytes.size();
      ++chunks;
    }
    CHECK(bytes == 3000 * kAedat4EventBytes);
    CHECK(source.acquire({}).error().code == ErrorCode::kTimeout);
    for (std::size_t i = 0; i < chunks; ++i) source.release();
    CHECK(source.acquire({}).ok());
    REQUIRE(source.start().ok());  // from the beginning
    CHECK(source.acquire({}).value().bytes.size() == limits::kChunkBytes);
  }

  TEST_CASE("colour frames become luma") {
    FrameRow bgr = some_frame(kBegin_us);
    bgr.format = 16;
    bgr.pixels.clear();
    FrameRow bgra = some_frame(kBegin_us + 1000);
    bgra.format = 24;
    bgra.pixels.clear();
    for (int i = 0; i < kWidth * kHeight; ++i) {
      bgr.pixels.insert(bgr.pixels.end(), {0, 0, 255});
      bgra.pixels.insert(bgra.pixels.end(), {255, 0, 0, 9});
    }
    const Played got =
        played(Aedat4File({}).add(1, frame_packet(bgr)).add(1, frame_packet(bgra)).bytes());
    REQUIRE(got.frames.size() == 2);
    CHECK(got.pixels[0][7] == 76);  // 0.299 * 255
    CHECK(got.pixels[1][7] == 29);  // 0.114 * 255
  }

  TEST_CASE("a frame of another size, or not later than the last, costs itself only") {
    const Played got = played(Aedat4File({})
                                  .add(1, frame_packet(some_frame(kBegin_us + 1000)))
                                  .add(1, frame_packet(some_frame(kBegin_us + 2000, 19, 10)))
                                  .add(1, frame_packet(some_frame(kBegin_us + 2000)))
                                  .add(1, frame_packet(some_frame(kBegin_us + 500)))
                                  .add(1, frame_packet(some_frame(kBegin_us + 3000)))
                                  .bytes());
    CHECK(got.frames.size() == 2);
    CHECK(got.frames.back().t.us == kBegin_us + 3000);
    CHECK(got.bad_frames == 1);
  }

  TEST_CASE("without a table, or with one that is none, the packets go on to the end") {
    const Aedat4File whole = whole_file({.table = false});
    const Bytes packets = whole.bytes();
    const std::size_t head_bytes = whole.head_bytes();
    const auto size = static_cast<std::int64_t>(packets.size());
    for (const std::int64_t position :
         {std::int64_t{-1}, std::int64_t{0}, std::int64_t{5}, size / 2, size - 1, size, size + 99,
          std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
      CAPTURE(position);
      Bytes bytes = whole.head(position);
      bytes.insert(bytes.end(), packets.begin() + static_cast<std::ptrdiff_t>(head_bytes),
                   packets.end());
      const Played got = played(bytes);
      CHECK(got.events.size() == 6000);
      CHECK(got.imu.size() == 4);
      CHECK(got.frames.size() == 2);
    }
    const TemporaryFolder folder;
    write_file(folder / "a.aedat4", packets);
    Problems problems;
    const auto recording = opened(folder / "a.aedat4", problems);
    REQUIRE(recording.ok());
    CHECK(says(surveyed(recording.value()).problems, {"a.aedat4", "table", "not closed"}));
  }

  TEST_CASE("streams that are not there are said to be missing") {
    const TemporaryFolder folder;
    write_file(
        folder / "a.aedat4",
        Aedat4File({.frames = false}).add(0, events_packet(some_events(kBegin_us, 10))).bytes());
    Problems problems;
    const auto recording = opened(folder / "a.aedat4", problems);
    REQUIRE(recording.ok());
    CHECK(recording.value().has(Stream::kEvents));
    CHECK(recording.value().has(Stream::kImu));
    CHECK_FALSE(recording.value().has(Stream::kFrames));
    CHECK(recording.value().require(Stream::kFrames, problems).error().code ==
          ErrorCode::kNotFound);
    CHECK(says(problems, {"error", "a.aedat4", "a stream of frames"}));
  }

  TEST_CASE("of two streams of a kind the first is read, and the others are named") {
    const TemporaryFolder folder;
    const std::string more =
        "<node name=\"7\"><attr key=\"typeIdentifier\" type=\"string\">EVTS</attr></node>"
        "<node name=\"8\"><attr key=\"typeIdentifier\" type=\"string\">POSE</attr></node>";
    write_file(folder / "a.aedat4", Aedat4File({.more = more})
                                        .add(7, events_packet(some_events(kBegin_us, 99)))
                                        .add(0, events_packet(some_events(kBegin_us, 10)))
                                        .add(8, triggers_packet(1))
                                        .bytes());
    Problems problems;
    const auto recording = opened(folder / "a.aedat4", problems);
    REQUIRE(recording.ok());
    CHECK(says(problems, {"warning", "stream 7 (EVTS) is not read: stream 0 is"}));
    CHECK(says(problems, {"warning", "stream 8 (POSE) is not read"}));
    CHECK(play(recording.value()).events.size() == 10);
  }

  TEST_CASE("a folder with one AEDAT file and its calibration is a recording") {
    const TemporaryFolder folder;
    write_file(folder / "walk.aedat4", whole_file({}).bytes());
    write_file(folder / "camchain.yaml", std::string("cam0:\n"));
    write_file(folder / "groundtruth.txt", std::string("0 1 2 3 0 0 0 1\n"));
    for (const std::string& path : {folder.path(), folder / "walk.aedat4"}) {
      CAPTURE(path);
      Problems problems;
      const auto recording = opened(path, problems);
      REQUIRE(recording.ok());
      CHECK(problems.empty());
      CHECK(recording.value().files().camchain == folder / "camchain.yaml");
      CHECK(recording.value().files().frames == folder / "walk.aedat4");
      CHECK(recording.value().has(Stream::kTruth) == (path == folder.path()));
      CHECK(play(recording.value()).events.size() == 6000);
    }
    write_file(folder / "other.aedat", std::string("#!AER-DAT2.0\r\n"));
    Problems problems;
    CHECK_FALSE(opened(folder.path(), problems).ok());
    CHECK(says(problems, {"error", "2 AEDAT files", "other.aedat", "walk.aedat4"}));
  }
}
