#include "pled_vins/sim/evt3_encoder.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <doctest/doctest.h>

using namespace pled;
using namespace pled::sim;

namespace {

Event event(std::int64_t t_us, int x, int y, Polarity polarity) {
  Event e;
  e.t = {t_us};
  e.x_px = static_cast<std::uint16_t>(x);
  e.y_px = static_cast<std::uint16_t>(y);
  e.polarity = polarity;
  return e;
}

std::vector<std::uint32_t> words(const std::vector<std::byte>& bytes) {
  std::vector<std::uint32_t> out;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2)
    out.push_back(std::to_integer<std::uint32_t>(bytes[i]) |
                  std::to_integer<std::uint32_t>(bytes[i + 1]) << 8U);
  return out;
}

// Word types of the EVT 3.0 description.
constexpr std::uint32_t kAddrY = 0x0000, kAddrX = 0x2000, kVectBase = 0x3000, kVect12 = 0x4000,
                        kVect8 = 0x5000, kTimeLow = 0x6000, kTimeHigh = 0x8000, kOnBit = 0x800;

}  // namespace

TEST_SUITE("sim.evt3_encoder") {
  TEST_CASE("an event is time high, time low, row, column with polarity") {
    Evt3Encoder encoder{240};
    std::vector<std::byte> bytes;
    encoder.encode(std::vector{event(5, 17, 33, Polarity::kOn)}, bytes);
    CHECK(words(bytes) == std::vector<std::uint32_t>{kTimeHigh | 0, kTimeLow | 5, kAddrY | 33,
                                                     kAddrX | kOnBit | 17});
  }

  TEST_CASE("time and row are sent again only when they change, also across calls") {
    Evt3Encoder encoder{240};
    std::vector<std::byte> bytes;
    encoder.encode(std::vector{event(5, 1, 3, Polarity::kOn)}, bytes);
    bytes.clear();
    encoder.encode(std::vector{event(5, 90, 3, Polarity::kOff), event(6, 2, 3, Polarity::kOff)},
                   bytes);
    CHECK(words(bytes) == std::vector<std::uint32_t>{kAddrX | 90, kTimeLow | 6, kAddrX | 2});
  }

  TEST_CASE("every 4096 us have their time high, also without events") {
    Evt3Encoder encoder{240};
    std::vector<std::byte> bytes;
    encoder.encode(std::vector{event(3 * 4096, 0, 0, Polarity::kOff)}, bytes);
    CHECK(words(bytes) == std::vector<std::uint32_t>{kTimeHigh | 0, kTimeHigh | 1, kTimeHigh | 2,
                                                     kTimeHigh | 3, kTimeLow | 0, kAddrY | 0,
                                                     kAddrX | 0});
  }

  TEST_CASE("five neighbours of one time, row and polarity become a vector group") {
    Evt3Encoder encoder{240};
    std::vector<Event> run;
    for (const int x : {100, 101, 112, 124, 131}) run.push_back(event(0, x, 7, Polarity::kOn));
    std::vector<std::byte> bytes;
    encoder.encode(run, bytes);
    CHECK(words(bytes) == std::vector<std::uint32_t>{kTimeHigh | 0, kTimeLow | 0, kAddrY | 7,
                                                     kVectBase | kOnBit | 100, kVect12 | 0x003,
                                                     kVect12 | 0x001, kVect8 | 0x81});
  }

  TEST_CASE("a vector group never reaches beyond the sensor") {
    Evt3Encoder encoder{240};
    std::vector<Event> run;
    for (int x = 235; x < 240; ++x) run.push_back(event(0, x, 7, Polarity::kOff));
    std::vector<std::byte> bytes;
    encoder.encode(run, bytes);
    const std::vector<std::uint32_t> w = words(bytes);
    REQUIRE(w.size() == 7);
    CHECK(w[3] == (kVectBase | (240 - 32)));
    CHECK(w[6] == (kVect8 | 0xf8));  // bits 27 ... 31 of the group
  }

  TEST_CASE("the header names the format and the size and ends") {
    CHECK(Evt3Encoder::raw_header(240, 180) ==
          "% evt 3.0\n% format EVT3;width=240;height=180\n% geometry 240x180\n% end\n");
  }
}
