#include <atomic>
#include <cstdlib>
#include <new>

#include <doctest/doctest.h>

#include "drivers/decode/text_event_decoder.hpp"
#include "drivers/replay/frame_source.hpp"
#include "drivers/replay/imu_source.hpp"
#include "drivers/replay/raw_file_source.hpp"
#include "drivers/replay/recording.hpp"
#include "unit/drivers/aedat2_writer.hpp"
#include "unit/drivers/aedat4_writer.hpp"
#include "unit/drivers/recording_writer.hpp"

namespace {

std::atomic<std::uint64_t> allocations{0};

void* counted(std::size_t bytes) {
  ++allocations;
  void* const memory = std::malloc(bytes);
  if (memory == nullptr) std::abort();
  return memory;
}

}  // namespace

void* operator new(std::size_t bytes) { return counted(bytes); }
void* operator new[](std::size_t bytes) { return counted(bytes); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

using namespace pled;
using namespace pled::replay;
using namespace pled::support;

namespace {

/// A second of everything, and faults.
Bytes aedat4_of(int compression) {
  Aedat4File file({.compression = compression});
  for (std::int64_t t_us = 0; t_us < 1'000'000; t_us += 10'000) {
    FrameRow frame{t_us, 0, 0, 0, 20, 10, pattern(20, 10)};
    const std::vector<Event> events(100, {{t_us}, 3, 4, Polarity::kOn});
    file.add(0, events_packet(events)).add(0, triggers_packet(1));
    file.add(2, imu_packet({{t_us, {1, 0, 0}, {}}})).add(2, triggers_packet(1));
    file.add(1, frame_packet(frame)).add(1, triggers_packet(1));
  }
  return file.bytes();
}

std::vector<std::byte> aedat2_of_a_second() {
  Pairs pairs;
  for (unsigned t_us = 0; t_us < 1'000'000; t_us += 1000) {
    for (unsigned i = 0; i < 100; ++i) pairs.push_back({dvs(i, 7, true), t_us});
    add_imu(pairs, t_us, {1, 2, 3, 4, 5, 6, 7});
    pairs.push_back({imu_word(3, 0), t_us});
  }
  return aedat2_file(kAedat2Head, pairs);
}

struct Counts {
  std::size_t events = 0;
  std::size_t samples = 0;
  std::size_t frames = 0;
};

/// Plays all streams of a recording and says how often memory was asked for meanwhile.
std::uint64_t allocations_of_playing(const Recording& recording, Counts& counts) {
  Problems problems;
  auto events = recording.open_events(problems);
  auto imu = recording.open_imu(problems);
  REQUIRE(events.ok());
  REQUIRE(imu.ok());
  std::unique_ptr<RecordedFrameSource> frames;
  if (recording.has(Stream::kFrames))
    frames = std::move(recording.open_frames(1, problems)).value();
  std::vector<Event> out(EventDecoder::kMinOutput);
  EventSource& source = *events.value().source;
  const std::uint64_t before = allocations;
  const bool started = source.start().ok();
  for (auto chunk = source.acquire({}); started && chunk.ok(); chunk = source.acquire({})) {
    std::span<const std::byte> bytes = chunk.value().bytes;
    while (!bytes.empty()) {
      const DecodeStep step = events.value().decoder->decode(bytes, out);
      bytes = bytes.subspan(step.bytes_consumed);
      counts.events += step.events;
    }
    source.release();
  }
  for (auto sample = imu.value()->read({});
       sample.ok() || sample.error().code == ErrorCode::kBadNumber; sample = imu.value()->read({}))
    counts.samples += sample.ok() ? 1U : 0U;
  while (frames != nullptr) {
    const auto frame = frames->acquire({});
    if (!frame.ok() && frame.error().code != ErrorCode::kCorrupt) break;
    if (!frame.ok()) continue;
    ++counts.frames;
    frames->release();
  }
  return allocations - before;
}

}  // namespace

TEST_SUITE("drivers.allocations") {
  TEST_CASE("reading a long text file of events allocates nothing after opening") {
    const TemporaryFolder folder;
    std::string text;
    constexpr int kLines = 200'000;
    for (int i = 0; i < kLines; ++i) text += std::to_string(i) + "e-6 12 34 1\n";
    write_file(folder / "events.txt", text);
    auto source = RawFileSource::open((folder / "events.txt").c_str(), {0, true});
    REQUIRE(source.ok());
    TextEventDecoder decoder(240, 180);
    std::vector<Event> out(EventDecoder::kMinOutput);
    const std::uint64_t before = allocations;
    std::size_t events = 0;
    REQUIRE(source.value()->start().ok());
    for (auto chunk = source.value()->acquire(Duration{}); chunk.ok();
         chunk = source.value()->acquire(Duration{})) {
      std::span<const std::byte> bytes = chunk.value().bytes;
      while (!bytes.empty()) {
        const DecodeStep step = decoder.decode(bytes, out);
        bytes = bytes.subspan(step.bytes_consumed);
        events += step.events;
      }
      source.value()->release();
    }
    const std::uint64_t after = allocations;
    CHECK(events == kLines);
    CHECK(after == before);
  }

  TEST_CASE("reading inertial samples allocates nothing, faults included") {
    const TemporaryFolder folder;
    std::string text;
    for (int i = 0; i < 20'000; ++i) text += std::to_string(i) + "e-3 1 2 3 4 5 6\nfault\n";
    write_file(folder / "imu.txt", text);
    auto source = ImuFileSource::open(folder / "imu.txt", ImuFormat::kRpg);
    REQUIRE(source.ok());
    const std::uint64_t before = allocations;
    int samples = 0;
    while (true) {
      const auto sample = source.value()->read(Duration{});
      if (sample.ok()) ++samples;
      if (!sample.ok() && sample.error().code == ErrorCode::kEndOfStream) break;
    }
    const std::uint64_t after = allocations;
    CHECK(samples == 20'000);
    CHECK(after == before);
  }

  TEST_CASE("reading frames allocates nothing of ours, faults included") {
    const TemporaryFolder folder;
    write_grey_png(folder / "a.png", 60, 40);
    write_jpeg(folder / "a.jpg", 60, 40, pattern(60, 40));
    write_grey_png(folder / "cut.png", 60, 40);
    truncate_file(folder / "cut.png", 0.5);
    std::string list;
    for (int i = 0; i < 60; i += 3) {
      list += std::to_string(i) + " a.png\n" + std::to_string(i + 1) + " a.jpg\n" +
              std::to_string(i + 2) + " cut.png\n";
    }
    write_file(folder / "images.txt", list);
    auto source = FrameFileSource::open(
        {folder / "images.txt", folder.path(), FrameListFormat::kRpg, {60, 40}, 1});
    REQUIRE(source.ok());
    const std::uint64_t before = allocations;
    int frames = 0;
    while (true) {
      const auto frame = source.value()->acquire(Duration{});
      if (frame.ok()) {
        ++frames;
        source.value()->release();
      } else if (frame.error().code == ErrorCode::kEndOfStream) {
        break;
      }
    }
    const std::uint64_t after = allocations;
    CHECK(frames == 40);
    CHECK(after == before);
  }

  TEST_CASE("playing an AEDAT file allocates nothing of ours after opening, faults included") {
    for (const int compression : {0, 1, 3}) {
      CAPTURE(compression);
      if (!can_pack(compression)) continue;
      const TemporaryFolder folder;
      write_file(folder / "a.aedat4", aedat4_of(compression));
      Problems problems;
      const auto recording = Recording::open(folder / "a.aedat4", problems);
      REQUIRE(recording.ok());
      Counts counts;
      CHECK(allocations_of_playing(recording.value(), counts) == 0);
      CHECK(counts.events == 100 * 100);
      CHECK(counts.samples == 100);
      CHECK(counts.frames == 100);
    }
    const TemporaryFolder folder;
    write_file(folder / "a.aedat", aedat2_of_a_second());
    Problems problems;
    const auto recording = Recording::open(folder / "a.aedat", problems);
    REQUIRE(recording.ok());
    Counts counts;
    CHECK(allocations_of_playing(recording.value(), counts) == 0);
    CHECK(counts.events == 100 * 1000);
    CHECK(counts.samples == 1000);
  }
}
