#include <algorithm>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

#include "drivers/decode/aedat2_event_decoder.hpp"
#include "drivers/decode/aedat2_frame.hpp"
#include "drivers/decode/aedat2_imu.hpp"
#include "unit/drivers/aedat2_writer.hpp"
#include "unit/drivers/evt3_words.hpp"

using namespace pled;
using namespace pled::support;

namespace {

constexpr int kWidth = 240;
constexpr int kHeight = 180;

std::vector<Aedat2Record> records_of(Aedat2Records& records, const Pairs& pairs) {
  const std::vector<std::byte> bytes = wire(pairs);
  std::span<const std::byte> rest = bytes;
  std::vector<Aedat2Record> out;
  while (const auto record = records.next(rest)) out.push_back(*record);
  return out;
}

std::vector<std::int64_t> times_of(Aedat2Records& records,
                                   const std::vector<std::uint32_t>& stamps) {
  Pairs pairs;
  for (const std::uint32_t stamp : stamps) pairs.push_back({dvs(1, 1, true), stamp});
  std::vector<std::int64_t> out;
  for (const Aedat2Record& record : records_of(records, pairs)) out.push_back(record.t_us);
  return out;
}

std::vector<std::int64_t> times_of(const std::vector<std::uint32_t>& stamps) {
  Aedat2Records records;
  return times_of(records, stamps);
}

/// What a collector of 2 x 2 frames makes of records with these addresses, 1 us apart.
struct Frames {
  std::vector<std::uint16_t> samples = std::vector<std::uint16_t>(8);
  Aedat2FrameCollector collector{2, 2, samples};
  std::int64_t t_us = 0;
  bool take(std::uint32_t address) { return collector.take({t_us++, address}); }
};

}  // namespace

TEST_SUITE("drivers.aedat2_decoders") {
  TEST_CASE("the address tells an event, a special event, a read and an inertial word apart") {
    const auto kind = [](std::uint32_t address) { return Aedat2Record{0, address}.kind(); };
    CHECK(kind(dvs(1023, 511, true)) == Aedat2Kind::kEvent);
    CHECK(kind(special()) == Aedat2Kind::kSpecial);
    CHECK(kind(reset_read(1023, 511, 1023)) == Aedat2Kind::kReset);
    CHECK(kind(signal_read(1023, 511, 1023)) == Aedat2Kind::kSignal);
    CHECK(kind(imu_word(6, -1)) == Aedat2Kind::kImu);
    CHECK(kind(1U << 31 | 1U << 11) == Aedat2Kind::kUnknown);
  }

  TEST_CASE("events are given from the upper left corner") {
    Aedat2EventDecoder decoder(kWidth, kHeight);
    const auto bytes = wire(Pairs{{dvs(0, 0, true), 5}, {dvs(239, 179, false), 6}});
    CHECK(same(decode_all(decoder, bytes),
               {{{5}, 239, 179, Polarity::kOn}, {{6}, 0, 0, Polarity::kOff}}));
  }

  TEST_CASE("the event decoder passes over all that is no event and counts what it drops") {
    Aedat2EventDecoder decoder(kWidth, kHeight);
    Pairs pairs{{dvs(1, 1, true), 1}, {special(), 2}, {reset_read(1, 1, 9), 3}};
    add_imu(pairs, 4, {1, 2, 3, 4, 5, 6, 7});
    pairs.insert(pairs.end(), {{dvs(240, 1, true), 5},
                               {dvs(1, 180, true), 6},
                               {1U << 31 | 1U << 11, 7},
                               {dvs(2, 2, true), 8}});
    CHECK(decode_all(decoder, wire(pairs)).size() == 2);
    CHECK(decoder.faults().outside_sensor == 2);
    CHECK(decoder.faults().malformed == 1);
  }

  TEST_CASE("time goes on over the wrap of 32 bits, and over that of the sign") {
    const std::uint32_t half = 0x7FFFFFFF;
    CHECK(times_of({half - 1, half, half + 1, half + 3}) ==
          std::vector<std::int64_t>{half - 1LL, half, half + 1LL, half + 3LL});
    Aedat2Records records;
    std::vector<std::uint32_t> stamps;
    for (std::uint64_t t = 0; t < (std::uint64_t{1} << 33); t += 100'000)
      stamps.push_back(static_cast<std::uint32_t>(t));
    const auto times = times_of(records, stamps);
    REQUIRE(times.size() == stamps.size());
    CHECK(times.back() == 100'000LL * static_cast<std::int64_t>(stamps.size() - 1));
    CHECK(records.faults().restarts == 0);
  }

  TEST_CASE("a stamp that goes back is told as it is, and held and counted for events") {
    CHECK(times_of({100, 300, 200, 400}) == std::vector<std::int64_t>{100, 300, 200, 400});
    Aedat2EventDecoder decoder(kWidth, kHeight);
    const std::uint32_t event = dvs(1, 1, true);
    const auto events =
        decode_all(decoder, wire(Pairs{{event, 100}, {event, 300}, {event, 200}, {event, 400}}));
    REQUIRE(events.size() == 4);
    CHECK(events[2].t.us == 300);
    CHECK(decoder.faults().time_backwards == 1);
  }

  TEST_CASE("one damaged stamp is dropped, wherever it stands") {
    for (std::size_t at = 0; at < 5; ++at) {
      for (unsigned bit = 18; bit < 32; ++bit) {
        CAPTURE(at);
        CAPTURE(bit);
        std::vector<std::uint32_t> stamps{100, 200, 300, 400, 500};
        std::vector<std::int64_t> expected(stamps.begin(), stamps.end());
        stamps[at] ^= 1U << bit;
        expected.erase(expected.begin() + static_cast<std::ptrdiff_t>(at));
        // Of the first two nobody can tell which one is damaged: both wait in vain.
        if (at == 1) expected.erase(expected.begin());
        Aedat2Records records;
        CHECK(times_of(records, stamps) == expected);
        records.finish();
        CHECK(records.faults().malformed + records.faults().unconfirmed == 5 - expected.size());
        CHECK(records.faults().restarts == 0);
      }
    }
  }

  TEST_CASE("a clock that was set back goes on from where it was, and is counted") {
    Aedat2Records records;
    CHECK(times_of(records, {9'000'000, 9'000'100, 0, 50, 150}) ==
          std::vector<std::int64_t>{9'000'000, 9'000'100, 9'000'100, 9'000'150, 9'000'250});
    CHECK(records.faults().restarts == 1);
    CHECK(records.faults().malformed == 0);
  }

  TEST_CASE("a silence loses nothing and is no restart") {
    const std::vector<std::int64_t> expected{0, 10, 30'000'000, 30'000'010};
    Aedat2Records records;
    CHECK(times_of(records, {0, 10, 30'000'000, 30'000'010}) == expected);
    CHECK(records.faults().restarts == 0);
  }

  TEST_CASE("seven words are one inertial sample in m/s^2 and rad/s on the chip's axes") {
    Aedat2ImuCollector collector({});
    Pairs pairs{{dvs(1, 1, true), 900}};
    add_imu(pairs, 1000, {4096, -8192, 2048, 99, 328, -656, 32767});
    Aedat2Records records;
    std::optional<ImuSample> sample;
    int samples = 0;
    for (const Aedat2Record& record : records_of(records, pairs)) {
      if (const auto taken = collector.take(record)) sample = taken;
      samples += sample ? 1 : 0;
    }
    REQUIRE(samples == 1);
    CHECK(sample->t.us == 1000);
    CHECK(sample->accel_mps2[0] == doctest::Approx(9.80665));
    CHECK(sample->accel_mps2[1] == doctest::Approx(-2.0 * 9.80665));
    CHECK(sample->accel_mps2[2] == doctest::Approx(0.5 * 9.80665));
    CHECK(sample->gyro_radps[0] == doctest::Approx(10.0 * std::numbers::pi / 180.0));
    CHECK(sample->gyro_radps[1] == doctest::Approx(-20.0 * std::numbers::pi / 180.0));
    CHECK(sample->gyro_radps[2] == doctest::Approx(999.0 * std::numbers::pi / 180.0).epsilon(1e-4));
    CHECK(collector.malformed() == 0);
  }

  TEST_CASE("an inertial group that lacks a word gives no sample and is counted") {
    for (unsigned missing = 0; missing < 7; ++missing) {
      CAPTURE(missing);
      Aedat2ImuCollector collector({});
      int samples = 0;
      for (int group = 0; group < 3; ++group)
        for (unsigned code = 0; code < 7; ++code)
          if (group != 1 || code != missing)
            samples += collector.take({group * 10, imu_word(code, 1)}) ? 1 : 0;
      collector.finish();
      CHECK(samples == 2);
      CHECK(collector.malformed() >= 1);
    }
  }

  TEST_CASE("a frame is the difference of its two reads, from the upper left corner") {
    Frames frames;
    for (unsigned i = 0; i < 4; ++i) CHECK_FALSE(frames.take(reset_read(i % 2, i / 2, 800)));
    for (unsigned i = 0; i < 3; ++i)
      CHECK_FALSE(frames.take(signal_read(i % 2, i / 2, 400 + 100 * i)));
    REQUIRE(frames.take(signal_read(1, 1, 900)));
    std::vector<std::uint8_t> pixels(4, 77);
    frames.collector.render(pixels);
    // Below: (800 - 400) / 4, (800 - 500) / 4; above: (800 - 600) / 4, and darker than black.
    CHECK(pixels == std::vector<std::uint8_t>{50, 0, 100, 75});
    CHECK(frames.collector.t_us() ==
          3);  // between the last reset at 3 us and the first signal at 4
    CHECK(frames.collector.incomplete() == 0);
  }

  TEST_CASE("the order of the reads of a frame does not matter") {
    std::mt19937_64 random(7);
    std::vector<std::uint8_t> expected;
    for (int run = 0; run < 20; ++run) {
      std::vector<unsigned> order{0, 1, 2, 3};
      std::shuffle(order.begin(), order.end(), random);
      Frames frames;
      bool whole = false;
      for (const unsigned i : order) {
        whole = frames.take(reset_read(i % 2, i / 2, 500 + i)) || whole;
        whole = frames.take(signal_read(i % 2, i / 2, 100 * i)) || whole;
      }
      REQUIRE(whole);
      std::vector<std::uint8_t> pixels(4);
      frames.collector.render(pixels);
      if (expected.empty()) expected = pixels;
      CHECK(pixels == expected);
      CHECK(frames.collector.t_us() == 3);  // the mean of 0, 6, 1 and 7 us, rounded down
    }
  }

  TEST_CASE("a frame that lacks reads is lost and counted, and the next one is whole") {
    Frames frames;
    int whole = 0;
    // The file begins within a frame; of the second a read is lost.
    whole += frames.take(signal_read(1, 1, 5)) ? 1 : 0;
    for (int frame = 0; frame < 3; ++frame) {
      for (unsigned i = 0; i < 4; ++i) whole += frames.take(reset_read(i % 2, i / 2, 9)) ? 1 : 0;
      for (unsigned i = 0; i < 4; ++i)
        if (frame != 1 || i != 2) whole += frames.take(signal_read(i % 2, i / 2, 5)) ? 1 : 0;
    }
    CHECK(whole == 2);
    CHECK(frames.collector.incomplete() == 1);
    CHECK_FALSE(frames.take(reset_read(2, 0, 1)));
    CHECK(frames.collector.outside() == 1);
  }
}
