#include "drivers/decode/evt3_decoder.hpp"

#include <doctest/doctest.h>

#include "unit/drivers/evt3_words.hpp"

using namespace pled;
using namespace pled::support;

namespace {

constexpr Polarity kOn = Polarity::kOn;
constexpr Polarity kOff = Polarity::kOff;
constexpr std::int64_t kHighUs = 4096;
constexpr std::int64_t kLoopUs = 1 << 24;

/// Time of one event after the words, from a decoder that is synchronised.
std::int64_t time_after(Evt3Decoder& decoder, Words words) {
  words.insert(words.end(), {addr_y(0), cd(0, kOn)});
  const auto events = decode_all(decoder, words);
  REQUIRE_FALSE(events.empty());
  return events.back().t.us;
}

}  // namespace

TEST_SUITE("drivers.evt3_decoder") {
  TEST_CASE("an address word is one event at the kept row and time") {
    Evt3Decoder decoder(640, 480);
    const auto events =
        decode_all(decoder, {time_high(3), time_low(5), addr_y(7), cd(12, kOn), cd(639, kOff)});
    REQUIRE(events.size() == 2);
    CHECK(same(events[0], {{3 * kHighUs + 5}, 12, 7, kOn}));
    CHECK(same(events[1], {{3 * kHighUs + 5}, 639, 7, kOff}));
  }

  TEST_CASE("the camera bit of a row address is not part of the row") {
    Evt3Decoder decoder(640, 480);
    const auto events = decode_all(decoder, {time_high(1), evt3(0, 0x800 | 9), cd(1, kOn)});
    REQUIRE(events.size() == 1);
    CHECK(events[0].y_px == 9);
  }

  TEST_CASE("vectors of 12, 12 and 8 pixels follow one base with its polarity") {
    Evt3Decoder decoder(640, 480);
    const auto events =
        decode_all(decoder, {time_high(1), addr_y(2), vect_base(100, kOff), vect_12(0x801),
                             vect_12(0x002), vect_8(0x80), cd(3, kOn)});
    REQUIRE(events.size() == 5);
    CHECK(events[0].x_px == 100);
    CHECK(events[1].x_px == 111);
    CHECK(events[2].x_px == 100 + 12 + 1);
    CHECK(events[3].x_px == 100 + 12 + 12 + 7);
    for (int i = 0; i < 4; ++i) CHECK(events[static_cast<std::size_t>(i)].polarity == kOff);
    CHECK(events[4].polarity == kOn);
  }

  TEST_CASE("a short vector ignores its four unused bits") {
    Evt3Decoder decoder(640, 480);
    CHECK(decode_all(decoder, {time_high(1), addr_y(2), vect_base(0, kOn), vect_8(0xF00)}).empty());
  }

  TEST_CASE("events off the sensor are dropped and counted one by one") {
    Evt3Decoder decoder(240, 180);
    const auto events =
        decode_all(decoder, {time_high(1), addr_y(179), cd(239, kOn), cd(240, kOn),  // 1 outside
                             vect_base(232, kOn), vect_12(0xFFF),                    // 4 outside
                             vect_8(0x03),                                           // 2 outside
                             addr_y(180), cd(0, kOn), vect_base(0, kOn), vect_8(0x07)});  // 4
    CHECK(events.size() == 1 + 8);
    for (const Event& event : events) {
      CHECK(event.x_px < 240);
      CHECK(event.y_px < 180);
    }
    CHECK(decoder.faults().outside_sensor == 1 + 4 + 2 + 4);
  }

  TEST_CASE("event words before the first time, row or base are skipped and counted") {
    Evt3Decoder decoder(640, 480);
    CHECK(decode_all(decoder, {addr_y(1), cd(1, kOn), vect_base(0, kOn), vect_8(0xFF)}).empty());
    CHECK(decoder.faults().before_sync == 2);

    Evt3Decoder rowless(640, 480);
    CHECK(decode_all(rowless, {time_high(1), cd(1, kOn)}).empty());
    CHECK(rowless.faults().before_sync == 1);

    Evt3Decoder baseless(640, 480);
    CHECK(decode_all(baseless, {time_high(1), addr_y(1), vect_8(0xFF)}).empty());
    CHECK(baseless.faults().before_sync == 1);
    CHECK(baseless.faults().outside_sensor == 0);
  }

  TEST_CASE("time low before the first time high is not believed") {
    Evt3Decoder decoder(640, 480);
    CHECK(time_after(decoder, {time_low(4000), time_high(2)}) == 2 * kHighUs);
  }

  TEST_CASE("a new time high starts at time low zero, a repeated one keeps it") {
    Evt3Decoder decoder(640, 480);
    CHECK(time_after(decoder, {time_high(2), time_low(9)}) == 2 * kHighUs + 9);
    CHECK(time_after(decoder, {time_high(2)}) == 2 * kHighUs + 9);
    CHECK(time_after(decoder, {time_high(3)}) == 3 * kHighUs);
  }

  TEST_CASE("time unwraps to 64 bits over many wraps") {
    Evt3Decoder decoder(640, 480);
    std::int64_t high = 4090;
    for (int i = 0; i < 3 * 4096; ++i, ++high) {
      const auto word = static_cast<unsigned>(high % 4096);
      REQUIRE(time_after(decoder, {time_high(word), time_low(1)}) == high * kHighUs + 1);
    }
    CHECK(decoder.faults().time_backwards == 0);
    CHECK(decoder.faults().malformed == 0);
  }

  TEST_CASE("a wrap may skip some steps near the ends") {
    Evt3Decoder decoder(640, 480);
    CHECK(time_after(decoder, {time_high(4080), time_high(10)}) == kLoopUs + 10 * kHighUs);
  }

  TEST_CASE("time low that steps back is held, and adds no 4096 us") {
    Evt3Decoder decoder(640, 480);
    CHECK(time_after(decoder, {time_high(2), time_low(100)}) == 2 * kHighUs + 100);
    CHECK(time_after(decoder, {time_low(89)}) == 2 * kHighUs + 100);
    CHECK(decoder.faults().time_backwards == 1);
    CHECK(time_after(decoder, {time_low(101)}) == 2 * kHighUs + 101);
    CHECK(decoder.faults().time_backwards == 1);
  }

  TEST_CASE("a late time high is counted and not believed, also across the wrap") {
    Evt3Decoder decoder(640, 480);
    CHECK(time_after(decoder, {time_high(9), time_high(8), time_low(7)}) == 9 * kHighUs + 7);
    CHECK(decoder.faults().time_backwards == 1);

    Evt3Decoder wrapped(640, 480);
    CHECK(time_after(wrapped, {time_high(4095), time_high(0), time_high(4095), time_high(1)}) ==
          kLoopUs + kHighUs);
    CHECK(wrapped.faults().time_backwards == 1);
  }

  TEST_CASE("one corrupt time high far off does not move the clock") {
    for (const unsigned corrupt : {100U + 64U, 100U + 2048U, 4095U, 0U}) {
      CAPTURE(corrupt);
      Evt3Decoder decoder(640, 480);
      CHECK(time_after(decoder, {time_high(100), time_high(corrupt), time_low(1)}) ==
            100 * kHighUs + 1);
      CHECK(time_after(decoder, {time_high(101), time_low(2)}) == 101 * kHighUs + 2);
      CHECK(decoder.faults().malformed == 1);
    }
  }

  TEST_CASE("a far time high that the next one confirms is a gap and is believed") {
    Evt3Decoder decoder(640, 480);
    CHECK(time_after(decoder, {time_high(100), time_high(900), time_high(901)}) == 901 * kHighUs);
    CHECK(decoder.faults().gaps == 1);
    // Over the wrap as well: from near the end to near the beginning.
    CHECK(time_after(decoder, {time_high(1000), time_high(1900), time_high(1901)}) ==
          1901 * kHighUs);
    CHECK(time_after(decoder, {time_high(3800), time_high(3801), time_high(300), time_high(301)}) ==
          kLoopUs + 301 * kHighUs);
  }

  TEST_CASE("no wrap is believed from the middle: the time is held instead") {
    Evt3Decoder decoder(640, 480);
    CHECK(time_after(decoder, {time_high(2000), time_high(500), time_high(501)}) == 2000 * kHighUs);
  }

  TEST_CASE("triggers and other words give no events; stray ones are counted") {
    Evt3Decoder decoder(640, 480);
    CHECK(decode_all(decoder, {time_high(1), addr_y(1), trigger(2, 1), others(0x16),
                               continued_12(1), continued_12(2), continued_4(3)})
              .empty());
    CHECK(decoder.triggers() == 1);
    CHECK(decoder.faults().malformed == 0);
    CHECK(decode_all(decoder, {continued_4(3), continued_12(1), evt3(0x9, 1), evt3(0xB, 1),
                               evt3(0xC, 1), evt3(0xD, 1)})
              .empty());
    CHECK(decoder.faults().malformed == 6);
    CHECK(decode_all(decoder, {cd(5, kOn)}).size() == 1);  // the row is still known
  }

  TEST_CASE("events after an exposure row are no brightness changes") {
    Evt3Decoder decoder(640, 480);
    const auto events = decode_all(decoder, {time_high(1), addr_y(1), evt3(0x1, 5), cd(1, kOn),
                                             vect_base(0, kOn), vect_8(1), addr_y(2), cd(2, kOn)});
    REQUIRE(events.size() == 1);
    CHECK(events[0].y_px == 2);
    CHECK(decoder.faults().malformed == 3);
  }

  TEST_CASE("after a gap nothing is given until row and time are known again") {
    Evt3Decoder decoder(640, 480);
    const auto before = decode_all(decoder, {time_high(7), addr_y(3), cd(1, kOn)});
    REQUIRE(before.size() == 1);
    const std::vector<std::byte> half{std::byte{0x55}};
    CHECK(decode_all(decoder, half).empty());
    decoder.resynchronise();  // the half word belongs to the lost bytes
    CHECK(
        decode_all(decoder, {cd(2, kOn), addr_y(4), cd(2, kOn), time_low(1), cd(2, kOn)}).empty());
    const auto after = decode_all(decoder, {time_high(500), cd(9, kOn)});
    REQUIRE(after.size() == 1);
    CHECK(same(after[0], {{500 * kHighUs}, 9, 4, kOn}));
    CHECK(decoder.faults().gaps == 1);
    CHECK(decoder.faults().before_sync == 3);
  }

  TEST_CASE("a word that the end of the stream cuts in half is malformed, once") {
    Evt3Decoder decoder(640, 480);
    const auto events = decode_all(decoder, {time_high(7), addr_y(3), cd(1, kOn)});
    CHECK(events.size() == 1);
    decoder.finish();
    CHECK(decoder.faults().malformed == 0);
    const std::vector<std::byte> half{std::byte{0x55}};
    CHECK(decode_all(decoder, half).empty());
    decoder.finish();
    decoder.finish();
    CHECK(decoder.faults().malformed == 1);
  }

  TEST_CASE("with little room a call stops early and the next goes on") {
    Evt3Decoder decoder(640, 480);
    Words words{time_high(1), addr_y(1)};
    for (int i = 0; i < 40; ++i) words.insert(words.end(), {vect_base(0, kOn), vect_12(0xFFF)});
    const auto bytes = wire(words);
    std::vector<Event> out(EventDecoder::kMinOutput);
    const DecodeStep step = decoder.decode(bytes, out);
    CHECK(step.bytes_consumed < bytes.size());
    CHECK(step.events == 60);
    const auto rest = decode_all(decoder, std::span{bytes}.subspan(step.bytes_consumed));
    CHECK(step.events + rest.size() == 40 * 12);
  }
}
