#include <cstdlib>
#include <limits>
#include <random>
#include <string>

#include <doctest/doctest.h>

#include "drivers/decode/aedat2_event_decoder.hpp"
#include "drivers/decode/aedat4_event_decoder.hpp"
#include "drivers/decode/evt3_decoder.hpp"
#include "drivers/decode/text_event_decoder.hpp"
#include "unit/drivers/aedat2_writer.hpp"
#include "unit/drivers/aedat4_writer.hpp"
#include "unit/drivers/evt3_words.hpp"

using namespace pled;
using namespace pled::support;

namespace {

constexpr int kWidth = 240;
constexpr int kHeight = 180;

std::vector<std::byte> random_bytes(std::uint64_t seed, std::size_t count) {
  std::mt19937_64 random(seed);
  std::vector<std::byte> bytes(count);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() & 0xFF);
  return bytes;
}

/// Words as a sensor sends them, with the events they stand for.
struct Scene {
  Words words;
  std::vector<Event> events;
};

Scene random_scene(std::uint64_t seed, int steps) {
  std::mt19937_64 random(seed);
  Scene scene;
  std::int64_t t_us = 4096LL * static_cast<std::int64_t>(random() % 4096);
  std::int64_t high = -1;
  for (int i = 0; i < steps; ++i) {
    t_us += static_cast<std::int64_t>(random() % 6000);
    while (high != t_us / 4096) {
      high = high < 0 ? t_us / 4096 : high + 1;
      scene.words.push_back(time_high(static_cast<unsigned>(high % 4096)));
    }
    scene.words.push_back(time_low(static_cast<unsigned>(t_us % 4096)));
    const auto y = static_cast<unsigned>(random() % kHeight);
    const auto polarity = static_cast<Polarity>(random() % 2);
    scene.words.push_back(addr_y(y));
    const auto keep = [&](unsigned x) {
      scene.events.push_back(
          {{t_us}, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), polarity});
    };
    if (random() % 2 == 0) {
      const auto x = static_cast<unsigned>(random() % kWidth);
      scene.words.push_back(cd(x, polarity));
      keep(x);
      continue;
    }
    const auto base = static_cast<unsigned>(random() % (kWidth - 32 + 1));
    const auto mask = static_cast<unsigned>(random());
    scene.words.insert(scene.words.end(), {vect_base(base, polarity), vect_12(mask & 0xFFF),
                                           vect_12(mask >> 12 & 0xFFF), vect_8(mask >> 24 & 0xFF)});
    for (unsigned bit = 0; bit < 32; ++bit) {
      if ((mask >> bit & 1U) != 0) keep(base + bit);
    }
  }
  return scene;
}

Event random_event(std::mt19937_64& random, std::int64_t t_us) {
  return {{t_us},
          static_cast<std::uint16_t>(random() % kWidth),
          static_cast<std::uint16_t>(random() % kHeight),
          static_cast<Polarity>(random() % 2)};
}

template <typename Decoder>
void check_all_cuts(const std::vector<std::byte>& bytes, const std::vector<Event>& expected) {
  for (std::size_t part = 1; part < 64; ++part) {
    CAPTURE(part);
    Decoder decoder(kWidth, kHeight);
    REQUIRE(same(decode_all(decoder, bytes, part), expected));
    decoder.finish();
    REQUIRE(decoder.faults().malformed == 0);
  }
  Decoder decoder(kWidth, kHeight);
  CHECK(same(decode_all(decoder, bytes), expected));
}

}  // namespace

TEST_SUITE("drivers.event_decoder") {
  TEST_CASE("encoding then decoding gives the same events, over wraps of the time") {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      CAPTURE(seed);
      const Scene scene = random_scene(seed, 20000);  // 60 s: more than three wraps
      Evt3Decoder decoder(kWidth, kHeight);
      const auto events = decode_all(decoder, scene.words);
      CHECK(same(events, scene.events));
      CHECK(decoder.faults().malformed == 0);
    }
  }

  TEST_CASE("EVT3: where the bytes are cut into chunks does not matter") {
    const auto bytes = wire(random_scene(4, 60).words);
    Evt3Decoder whole(kWidth, kHeight);
    const auto expected = decode_all(whole, bytes);
    REQUIRE(expected.size() > 100);
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
      CAPTURE(cut);
      Evt3Decoder decoder(kWidth, kHeight);
      auto events = decode_all(decoder, std::span{bytes}.first(cut));
      const auto rest = decode_all(decoder, std::span{bytes}.subspan(cut));
      events.insert(events.end(), rest.begin(), rest.end());
      REQUIRE(same(events, expected));
    }
    for (const std::size_t part : {1U, 2U, 3U, 7U}) {
      Evt3Decoder decoder(kWidth, kHeight);
      CHECK(same(decode_all(decoder, bytes, part), expected));
    }
  }

  TEST_CASE("text: where the bytes are cut into chunks does not matter") {
    const std::string text =
        "# comment\n0.000001 1 2 1\r\n0.000002 3 4 0\nnan 1 1 1\n\n0.000003 500 4 0\n"
        "1.5e-1 7 8 -1\n0.1 9 10 1\n0.2 11 12 1\n";
    const auto bytes = std::as_bytes(std::span{text});
    TextEventDecoder whole(kWidth, kHeight);
    const auto expected = decode_all(whole, bytes);
    REQUIRE(expected.size() == 5);
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
      CAPTURE(cut);
      TextEventDecoder decoder(kWidth, kHeight);
      auto events = decode_all(decoder, bytes.first(cut));
      const auto rest = decode_all(decoder, bytes.subspan(cut));
      events.insert(events.end(), rest.begin(), rest.end());
      REQUIRE(same(events, expected));
      REQUIRE(decoder.faults().malformed == 1);
      REQUIRE(decoder.faults().outside_sensor == 1);
      REQUIRE(decoder.faults().time_backwards == 1);
    }
  }

  TEST_CASE("AEDAT 4: decoding gives what was encoded, wherever the bytes are cut") {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      CAPTURE(seed);
      std::mt19937_64 random(seed);
      std::vector<std::byte> bytes;
      std::vector<Event> expected;
      std::int64_t t_us = 1'605'537'493'718'345;
      for (int i = 0; i < 300; ++i) {
        // Now and then longer than a stamp is believed at once.
        t_us += static_cast<std::int64_t>(random() % 50 == 0 ? 2'000'000 : random() % 300);
        const Event event = random_event(random, t_us);
        expected.push_back(event);
        const auto record =
            event_record(t_us, event.x_px, event.y_px, static_cast<int>(event.polarity));
        bytes.insert(bytes.end(), record.begin(), record.end());
      }
      check_all_cuts<Aedat4EventDecoder>(bytes, expected);
    }
  }

  TEST_CASE("AEDAT 2: decoding gives what was encoded, wherever the bytes are cut") {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      CAPTURE(seed);
      std::mt19937_64 random(seed);
      Pairs pairs;
      std::vector<Event> expected;
      std::int64_t t_us = 0xFFFF'0000;  // wraps soon
      const std::int64_t begin_us = static_cast<std::int32_t>(t_us) - t_us;
      for (int i = 0; i < 500; ++i) {
        t_us += static_cast<std::int64_t>(random() % 300);
        const auto stamp = static_cast<std::uint32_t>(t_us);
        const Event event = random_event(random, begin_us + t_us);
        if (random() % 3 == 0) {
          add_imu(pairs, stamp, {1, 2, 3, 4, 5, 6, 7});
          continue;
        }
        expected.push_back(event);
        pairs.push_back(
            {dvs(static_cast<unsigned>(kWidth - 1 - event.x_px),
                 static_cast<unsigned>(kHeight - 1 - event.y_px), event.polarity == Polarity::kOn),
             stamp});
      }
      check_all_cuts<Aedat2EventDecoder>(wire(pairs), expected);
    }
  }

  TEST_CASE_TEMPLATE("any bytes: all are consumed, no event is outside, time never decreases",
                     Decoder, Evt3Decoder, TextEventDecoder, Aedat2EventDecoder,
                     Aedat4EventDecoder) {
    for (std::uint64_t seed = 10; seed < 30; ++seed) {
      CAPTURE(seed);
      const auto bytes = random_bytes(seed, 50'001);
      Decoder decoder(kWidth, kHeight);
      std::span<const std::byte> rest = bytes;
      std::vector<Event> out(EventDecoder::kMinOutput + seed);
      std::int64_t last_us = std::numeric_limits<std::int64_t>::min();
      while (!rest.empty()) {
        const auto part = rest.first(std::min<std::size_t>(rest.size(), 4097));
        const DecodeStep step = decoder.decode(part, out);
        REQUIRE(step.bytes_consumed > 0);
        REQUIRE(step.bytes_consumed <= part.size());
        REQUIRE(step.events <= out.size());
        for (const Event& event : std::span{out}.first(step.events)) {
          REQUIRE(event.x_px < kWidth);
          REQUIRE(event.y_px < kHeight);
          REQUIRE(event.t.us >= last_us);
          last_us = event.t.us;
        }
        rest = rest.subspan(step.bytes_consumed);
        if (rest.size() % 50 == 0) decoder.resynchronise();
      }
    }
  }

  TEST_CASE("one flipped bit in a time high never moves the clock by more than 66 ms") {
    constexpr std::int64_t kLimitUs = 16 * 4096 + 4096;
    for (unsigned bit = 0; bit < 12; ++bit) {
      for (const unsigned start : {0U, 100U, 2040U, 4090U}) {
        CAPTURE(bit);
        CAPTURE(start);
        Evt3Decoder decoder(kWidth, kHeight);
        for (unsigned step = 0; step < 60; ++step) {
          const unsigned high = (start + step) % 4096;
          const Word word = step == 7 ? time_high(high ^ (1U << bit)) : time_high(high);
          const auto events =
              decode_all(decoder, {word, time_low(0), addr_y(0), cd(0, Polarity::kOn)});
          REQUIRE(events.size() == 1);
          const std::int64_t true_us = 4096LL * (start + step);
          REQUIRE(std::abs(events[0].t.us - true_us) <= kLimitUs);
        }
      }
    }
  }
}
