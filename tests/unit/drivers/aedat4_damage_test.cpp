#include <random>

#include <doctest/doctest.h>

#include "drivers/replay/aedat4_reader.hpp"
#include "unit/drivers/aedat4_writer.hpp"
#include "unit/drivers/aedat_reading.hpp"
#include "unit/drivers/recording_writer.hpp"

using namespace pled;
using namespace pled::replay;
using namespace pled::support;

namespace {

std::vector<Event> events_from(std::int64_t begin_us) {
  return {{{begin_us}, 1, 1, Polarity::kOn}, {{begin_us + 10}, 2, 2, Polarity::kOff}};
}

FrameRow frame_at(std::int64_t t_us) {
  FrameRow row{t_us, 0, 0, 0, 4, 3, {}};
  row.pixels = pattern(4, 3);
  return row;
}

Aedat4File small_file(int compression, bool table) {
  Aedat4File file({.compression = compression, .table = table, .width = 4, .height = 3});
  file.add(0, events_packet(events_from(1000)))
      .add(1, frame_packet(frame_at(1000)))
      .add(2, imu_packet({{1000, {1, 0, 0}, {0, 0, 1}}}))
      .add(0, events_packet(events_from(2000)))
      .add(3, triggers_packet(1))
      .add(1, frame_packet(frame_at(2000)))
      .add(2, imu_packet({{2000, {1, 0, 0}, {0, 0, 1}}}));
  return file;
}

/// Writes and reads; nothing when the file is refused.
struct Reading {
  bool opened = false;
  Problems problems;
  Played played;
  std::vector<std::string> words;  ///< of the survey
};
Reading reading_of(const std::string& path, std::span<const std::byte> bytes, bool with_survey) {
  write_file(path, bytes);
  Reading out;
  const auto recording = Recording::open(path, out.problems);
  out.opened = recording.ok();
  if (!recording.ok()) return out;
  out.played = play(recording.value());
  if (!with_survey) return out;
  Problems ignored;
  const auto info = survey(recording.value(), ignored, {});
  REQUIRE(info.ok());
  out.words = info.value().problems;
  return out;
}

}  // namespace

TEST_SUITE("drivers.aedat4_damage") {
  TEST_CASE("a file that is cut at any byte gives what stands before the cut") {
    for (const int compression : {0, 1, 3}) {
      CAPTURE(compression);
      if (!can_pack(compression)) continue;
      const TemporaryFolder folder;
      const Aedat4File file = small_file(compression, true);
      const Bytes bytes = file.bytes();
      std::size_t most = 0;
      std::size_t surveys = 0;
      std::size_t readings = 0;
      constexpr std::size_t kMark = 9;  // what is shorter may be any text
      // Every byte of the packets once; the others differ in what a packet's content is.
      const std::size_t step = compression == 0 ? 1 : 9;
      for (std::size_t size = kMark; size < bytes.size();
           size += size + 16 < file.head_bytes() ? 16 : step) {
        CAPTURE(size);
        const bool seldom = readings++ % 16 == 0;
        const Reading got = reading_of(folder / "a.aedat4", std::span(bytes).first(size), seldom);
        if (size < file.head_bytes()) {
          CHECK_FALSE(got.opened);
          continue;
        }
        REQUIRE(got.opened);
        const std::size_t items =
            got.played.events.size() + got.played.imu.size() + got.played.frames.size();
        CHECK(items >= most);
        most = std::max(most, items);
        CHECK(got.played.faults.malformed + got.played.lost_packets == 0);
        if (!seldom) continue;
        CHECK_FALSE(got.words.empty());
        ++surveys;
      }
      CHECK(most == 4 + 2 + 2);
      CHECK(surveys > 3);
      const Reading whole = reading_of(folder / "a.aedat4", bytes, true);
      CHECK(whole.words.empty());
    }
  }

  TEST_CASE("a packet that cannot be unpacked or read is counted, and the next ones are read") {
    for (const int compression : {0, 1, 3}) {
      CAPTURE(compression);
      if (!can_pack(compression)) continue;
      const TemporaryFolder folder;
      const Bytes garbage{std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}, std::byte{5}};
      Aedat4File file({.compression = compression, .width = 4, .height = 3});
      file.add(0, events_packet(events_from(1000)));
      file.add(2, imu_packet({{1000, {1, 0, 0}, {0, 0, 1}}}));
      file.add(1, frame_packet(frame_at(1000)));
      for (const int stream : {0, 1, 2, 3}) file.add(stream, garbage);
      for (const int stream : {0, 1, 2}) file.add(stream, triggers_packet(1));
      file.add(0, events_packet(events_from(2000)));
      file.add(2, imu_packet({{2000, {1, 0, 0}, {0, 0, 1}}}));
      file.add(1, frame_packet(frame_at(2000)));
      const Reading got = reading_of(folder / "a.aedat4", file.bytes(), true);
      REQUIRE(got.opened);
      CHECK(got.played.events.size() == 4);
      CHECK(got.played.lost_packets == 2);
      CHECK(got.played.faults.gaps == 1);
      CHECK(got.played.imu.size() == 2);
      CHECK(got.played.bad_samples == 2);
      CHECK(got.played.frames.size() == 2);
      CHECK(got.played.bad_frames == 2);
      CHECK(says(got.words, {"2 packets of events"}));
      CHECK(says(got.words, {"1 packets of triggers"}));
    }
  }

  TEST_CASE("where no packet begins the reading ends, and that is said") {
    const auto head_of = [](std::int32_t stream, std::int32_t size) {
      Bytes bytes;
      append(bytes, stream);
      append(bytes, size);
      append(bytes, std::int64_t{0});
      return bytes;
    };
    for (const Bytes& broken : {head_of(99, 8), head_of(0, -1), head_of(-1, 8)}) {
      const TemporaryFolder folder;
      Aedat4File file({.table = false, .width = 4, .height = 3});
      file.add(0, events_packet(events_from(1000))).add_raw(broken);
      file.add(0, events_packet(events_from(2000)));
      const Reading got = reading_of(folder / "a.aedat4", file.bytes(), true);
      REQUIRE(got.opened);
      CHECK(got.played.events.size() == 2);
      CHECK(says(got.words, {"no packet begins", "cannot be read"}));
    }
  }

  TEST_CASE("a packet that says it is larger than all that is read is skipped") {
    if (!can_pack(3)) return;
    // 20 MB of zeros pack to some kilobytes.
    const TemporaryFolder folder;
    Aedat4File file({.compression = 3, .width = 4, .height = 3});
    file.add(0, Bytes(Aedat4Reader::kMaxPacketBytes + 1));
    file.add(0, events_packet(events_from(1000)));
    const Reading got = reading_of(folder / "a.aedat4", file.bytes(), false);
    REQUIRE(got.opened);
    CHECK(got.played.lost_packets == 1);
    CHECK(got.played.events.size() == 2);
  }

  TEST_CASE("any byte of a file may be changed: it is read or refused") {
    std::mt19937_64 random(5);
    const TemporaryFolder folder;
    const Bytes bytes = small_file(can_pack(1) ? 1 : 0, true).bytes();
    for (int run = 0; run < 150; ++run) {
      CAPTURE(run);
      Bytes changed = bytes;
      for (int k = 0; k < 3; ++k)
        changed[random() % changed.size()] = static_cast<std::byte>(random() & 0xFF);
      const Reading got = reading_of(folder / "a.aedat4", changed, false);
      std::int64_t last_us = std::numeric_limits<std::int64_t>::min();
      for (const Event& event : got.played.events) {
        CHECK(event.t.us >= last_us);
        last_us = event.t.us;
      }
    }
  }

  TEST_CASE("a compression that there is not, and files of other versions, are refused by name") {
    const TemporaryFolder folder;
    const auto words_of = [&](const Bytes& bytes) {
      Reading got = reading_of(folder / "a.aedat4", bytes, false);
      CHECK_FALSE(got.opened);
      return got.problems;
    };
    CHECK(says(words_of(Aedat4File({.compression = 77}).bytes()),
               {"error", "a.aedat4", "unknown way (77)"}));
    const auto text = [](const std::string& head) {
      const auto raw = std::as_bytes(std::span{head});
      return Bytes(raw.begin(), raw.end());
    };
    CHECK(says(words_of(text("#!AER-DAT3.1\r\n#Format: RAW\r\n")), {"version 3.1", "2.0 and 4.0"}));
    CHECK(says(words_of(text("#!AER-DAT4.0\r\n12345678")), {"AEDAT header"}));
    CHECK(says(words_of(text("#!AER-DAT4.0\r\n")), {"cut within the AEDAT header"}));
  }
}
