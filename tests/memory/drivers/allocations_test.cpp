#include <atomic>
#include <cstdlib>
#include <new>

#include <doctest/doctest.h>

#include "drivers/decode/text_event_decoder.hpp"
#include "drivers/replay/frame_source.hpp"
#include "drivers/replay/imu_source.hpp"
#include "drivers/replay/raw_file_source.hpp"
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
}
