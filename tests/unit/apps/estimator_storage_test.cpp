#include "src/apps/estimator_storage.hpp"

#include <cstddef>
#include <set>
#include <string_view>

#include <doctest/doctest.h>

namespace {

using namespace pled;
using namespace pled::apps;

std::size_t bytes_of(std::string_view name) {
  for (const BufferInfo& buffer : memory_table(limits::kDavis346))
    if (buffer.name == name) return buffer.bytes;
  FAIL("no row " << name);
  return 0;
}

TEST_SUITE("apps.estimator_storage") {
  TEST_CASE("the memory table leaves out no byte that grows with the sensor") {
    constexpr std::size_t kAtMostPadding = 256;
    const std::size_t stages = bytes_of("tracker.tracks") + bytes_of("events.stage") +
                               bytes_of("lines.stage") + bytes_of("imu.history") +
                               bytes_of("backend.window") + bytes_of("pipeline.messages") +
                               bytes_of("pipeline.event_batch") + bytes_of("health.counters");
    const std::size_t listed = static_bytes(limits::kDavis346) - stages;
    const std::size_t laid_out = sizeof(FrameTrackerStorage<346, 260>) +
                                 sizeof(EventStageStorage<346, 260>) +
                                 sizeof(LineStorage<346, 260>);
    CHECK(listed <= laid_out);
    CHECK(laid_out - listed < kAtMostPadding);
  }

  TEST_CASE("every row has a name of its own and bytes, and the rows add up") {
    for (const limits::SensorClass& sensor : limits::kSensorClasses) {
      CAPTURE(sensor.name);
      std::set<std::string_view> names;
      std::size_t sum = 0;
      for (const BufferInfo& buffer : memory_table(sensor)) {
        CHECK_MESSAGE(names.insert(buffer.name).second, buffer.name);
        CHECK_MESSAGE(buffer.bytes > 0, buffer.name);
        sum += buffer.bytes;
      }
      CHECK(names.contains("lines.pictures"));
      CHECK(sum == static_bytes(sensor));
    }
  }

  TEST_CASE("lines and both kinds of event picture have memory beside each other") {
    constexpr std::size_t kPixels = 346 * 260;
    CHECK(bytes_of("lines.pictures") == sizeof(LineStorage<346, 260>));
    CHECK(bytes_of("events.brightness") == kPixels * (sizeof(BrightnessPixel) + 1));
    CHECK(bytes_of("events.time_surface") == kPixels * (4 * sizeof(float) + 1));
  }
}

}  // namespace
