#include "drivers/decode/aedat4_packets.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <doctest/doctest.h>

#include "unit/drivers/aedat4_writer.hpp"

using namespace pled;
using namespace pled::support;

namespace {

constexpr double kGravity_mps2 = 9.80665;
constexpr double kDegree_rad = std::numbers::pi / 180.0;

FrameRow grey_frame() {
  FrameRow row{1000, 0, 0, 0, 3, 2, {}};
  row.pixels = {1, 2, 3, 4, 5, 6};
  return row;
}

/// Calls every reader of packets and goes through all that it gives: whatever lies outside is
/// read here, so that a sanitizer sees it. How many of them took the packet.
int read_as_anything(std::span<const std::byte> packet) {
  int taken = 0;
  unsigned sum = 0;
  if (const auto events = aedat4_events(packet)) {
    ++taken;
    for (const std::byte byte : *events) sum += std::to_integer<unsigned>(byte);
  }
  if (const auto samples = Aedat4ImuPacket::read(packet)) {
    ++taken;
    for (std::size_t i = 0; i < samples->size(); ++i)
      sum += samples->sample(i).has_value() ? 1U : 0U;
  }
  if (const auto frame = aedat4_frame(packet)) {
    ++taken;
    for (const std::byte byte : frame->pixels) sum += std::to_integer<unsigned>(byte);
  }
  taken += aedat4_trigger_count(packet) ? 1 : 0;
  taken += aedat4_table_size(packet) ? 1 : 0;
  CHECK(sum < 1U << 30);  // uses what was read
  return taken;
}

}  // namespace

TEST_SUITE("drivers.aedat4_packets") {
  TEST_CASE("events are given as the bytes that the packet holds") {
    const std::vector<Event> events{{{5}, 1, 2, Polarity::kOn}, {{6}, 3, 4, Polarity::kOff}};
    const Bytes packet = events_packet(events);
    const auto bytes = aedat4_events(packet);
    REQUIRE(bytes.has_value());
    Bytes expected = event_record(5, 1, 2, 1);
    const Bytes second = event_record(6, 3, 4, 0);
    expected.insert(expected.end(), second.begin(), second.end());
    CHECK(Bytes(bytes->begin(), bytes->end()) == expected);
  }

  TEST_CASE("a packet without its list holds nothing, and that is no fault") {
    FlatWriter out("EVTS");
    out.table(0, {});
    const auto bytes = aedat4_events(out.size_prefixed());
    REQUIRE(bytes.has_value());
    CHECK(bytes->empty());
  }

  TEST_CASE("a packet of one kind is not read as another") {
    const Bytes packet = triggers_packet(3);
    CHECK(aedat4_trigger_count(packet) == 3);
    CHECK(read_as_anything(packet) == 1);
  }

  TEST_CASE("inertial samples come in m/s^2 and rad/s on the axes of the file") {
    const Bytes packet = imu_packet({{77, {1.0F, -2.0F, 0.5F}, {180.0F, -90.0F, 1.0F}}});
    const auto samples = Aedat4ImuPacket::read(packet);
    REQUIRE(samples.has_value());
    REQUIRE(samples->size() == 1);
    const auto sample = samples->sample(0);
    REQUIRE(sample.has_value());
    CHECK(sample->t.us == 77);
    CHECK(sample->accel_mps2[0] == doctest::Approx(kGravity_mps2));
    CHECK(sample->accel_mps2[1] == doctest::Approx(-2.0 * kGravity_mps2));
    CHECK(sample->accel_mps2[2] == doctest::Approx(0.5 * kGravity_mps2));
    CHECK(sample->gyro_radps[0] == doctest::Approx(180.0 * kDegree_rad));
    CHECK(sample->gyro_radps[1] == doctest::Approx(-90.0 * kDegree_rad));
    CHECK(sample->gyro_radps[2] == doctest::Approx(kDegree_rad));
  }

  TEST_CASE("fields that the file leaves out are zero") {
    const Bytes packet = imu_packet({{9, {0.0F, 1.0F, 0.0F}, {0.0F, 0.0F, 2.0F}}, {}});
    const auto samples = Aedat4ImuPacket::read(packet);
    REQUIRE(samples.has_value());
    REQUIRE(samples->size() == 2);
    const auto first = samples->sample(0);
    REQUIRE(first.has_value());
    CHECK(first->accel_mps2[0] == 0.0);
    CHECK(first->accel_mps2[1] == doctest::Approx(kGravity_mps2));
    CHECK(first->gyro_radps[1] == 0.0);
    CHECK(first->gyro_radps[2] == doctest::Approx(2.0 * kDegree_rad));
    const auto second = samples->sample(1);
    REQUIRE(second.has_value());
    CHECK(second->t.us == 0);
    CHECK(second->accel_mps2 == std::array{0.0, 0.0, 0.0});
  }

  TEST_CASE("a sample that is not finite, or whose stamp no nanoseconds can hold, is none") {
    const float inf = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const Bytes packet = imu_packet({{1, {nan, 0, 0}, {}},
                                     {1, {}, {0, inf, 0}},
                                     {std::numeric_limits<std::int64_t>::max(), {}, {}},
                                     {1, {1, 1, 1}, {1, 1, 1}}});
    const auto samples = Aedat4ImuPacket::read(packet);
    REQUIRE(samples.has_value());
    for (std::size_t i = 0; i < 3; ++i) CHECK_FALSE(samples->sample(i).has_value());
    CHECK(samples->sample(3).has_value());
  }

  TEST_CASE("a frame is stamped at the middle of its exposure, where that is told") {
    FrameRow row = grey_frame();
    CHECK(aedat4_frame(frame_packet(row))->t_us == 1000);
    row.exposure_begin_us = 2000;
    row.exposure_end_us = 2600;
    CHECK(aedat4_frame(frame_packet(row))->t_us == 2300);
    row.exposure_end_us = 1900;  // ends before it begins
    CHECK(aedat4_frame(frame_packet(row))->t_us == 1000);
  }

  TEST_CASE("a frame has as many pixels as its size and format say, or is none") {
    FrameRow row = grey_frame();
    const Bytes packet = frame_packet(row);
    const auto frame = aedat4_frame(packet);
    REQUIRE(frame.has_value());
    CHECK(frame->width_px == 3);
    CHECK(frame->height_px == 2);
    CHECK(frame->pixels.size() == 6);
    CHECK(std::to_integer<int>(frame->pixels[5]) == 6);
    const auto is_frame = [&](int format, int width, int height, std::size_t pixels) {
      row.format = format;
      row.width = width;
      row.height = height;
      row.pixels.assign(pixels, 7);
      return aedat4_frame(frame_packet(row)).has_value();
    };
    CHECK(is_frame(16, 3, 2, 18));
    CHECK(is_frame(24, 3, 2, 24));
    CHECK_FALSE(is_frame(0, 3, 2, 5));
    CHECK_FALSE(is_frame(0, 3, 2, 7));
    CHECK_FALSE(is_frame(16, 3, 2, 6));
    CHECK_FALSE(is_frame(2, 3, 2, 12));
    CHECK_FALSE(is_frame(0, -3, -2, 6));
    CHECK_FALSE(is_frame(0, 0, 0, 0));
  }

  TEST_CASE("a packet that is cut, or has any one byte changed, is never read outside itself") {
    const std::vector<Event> events{{{5}, 1, 2, Polarity::kOn}};
    for (const Bytes& packet :
         {events_packet(events), imu_packet({{77, {1, 2, 3}, {4, 5, 6}}, {78, {}, {1, 0, 0}}}),
          frame_packet(grey_frame()), triggers_packet(2)}) {
      REQUIRE(read_as_anything(packet) == 1);
      for (std::size_t size = 0; size < packet.size(); ++size) {
        // In memory of exactly that size: the sanitizer guards its end.
        const Bytes cut(packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(size));
        CHECK(read_as_anything(cut) == 0);
      }
      for (std::size_t at = 0; at < packet.size(); ++at) {
        for (const unsigned value : {0x00U, 0x01U, 0x7FU, 0x80U, 0xFFU}) {
          Bytes changed = packet;
          changed[at] = static_cast<std::byte>(value);
          CHECK(read_as_anything(changed) <= 1);
        }
      }
    }
  }
}
