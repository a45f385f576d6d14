#include "drivers/decode/text_event_decoder.hpp"

#include <string>

#include <doctest/doctest.h>

#include "unit/drivers/evt3_words.hpp"

using namespace pled;
using namespace pled::support;

namespace {

std::vector<Event> decode_text(TextEventDecoder& decoder, const std::string& text) {
  return decode_all(decoder, std::as_bytes(std::span{text}));
}

}  // namespace

TEST_SUITE("drivers.text_event_decoder") {
  TEST_CASE("a line is an event, to the microsecond, with either way to write polarity") {
    TextEventDecoder decoder(240, 180);
    const auto events = decode_text(decoder,
                                    "0.003811000 96 133 0\n"
                                    "3.8200014e-3 127 171 1\n"
                                    "1403715273.262143135 0 0 -1\n"
                                    "1403715273.2621435\t239,179 +1\r\n");
    REQUIRE(events.size() == 4);
    CHECK(same(events[0], {{3811}, 96, 133, Polarity::kOff}));
    CHECK(same(events[1], {{3820}, 127, 171, Polarity::kOn}));
    CHECK(same(events[2], {{1403715273262143}, 0, 0, Polarity::kOff}));
    CHECK(same(events[3], {{1403715273262144}, 239, 179, Polarity::kOn}));
    CHECK(decoder.faults().malformed == 0);
  }

  TEST_CASE("comments and blank lines are no faults") {
    TextEventDecoder decoder(240, 180);
    CHECK(decode_text(decoder, "# t x y p\n\n   \r\n0.1 1 2 1\n").size() == 1);
    CHECK(decoder.faults().malformed == 0);
  }

  TEST_CASE("each malformed line is counted and the next one is read") {
    TextEventDecoder decoder(240, 180);
    const auto events = decode_text(decoder,
                                    "nan 1 2 1\n"
                                    "0.1 nan 2 1\n"
                                    "0.1 1 two 1\n"
                                    "0.1 1 2\n"
                                    "0.1 1 2 2\n"
                                    "0.1 1 2 1 7\n"
                                    "0.1 1.5 2 1\n"
                                    "0.1 99999999999 2 1\n"
                                    "\x01\xff garbage\n"
                                    "0.2 3 4 1\n");
    REQUIRE(events.size() == 1);
    CHECK(events[0].t.us == 200000);
    CHECK(decoder.faults().malformed == 9);
  }

  TEST_CASE("events off the sensor are dropped and counted") {
    TextEventDecoder decoder(240, 180);
    CHECK(decode_text(decoder, "0 240 0 1\n0 0 180 1\n0 -1 0 1\n0 70000 0 1\n").empty());
    CHECK(decoder.faults().outside_sensor == 4);
    CHECK(decoder.faults().malformed == 0);
  }

  TEST_CASE("a stamp below the last is held and counted") {
    TextEventDecoder decoder(240, 180);
    const auto events = decode_text(decoder, "-0.5 1 1 1\n-0.7 1 1 1\n-0.4 1 1 1\n");
    REQUIRE(events.size() == 3);
    CHECK(events[1].t.us == -500000);
    CHECK(events[2].t.us == -400000);
    CHECK(decoder.faults().time_backwards == 1);
  }

  TEST_CASE("a clock that is set back is followed after 64 stamps that agree, not before") {
    TextEventDecoder decoder(240, 180);
    const auto line = [](double t_s) { return std::to_string(t_s) + " 1 1 1\n"; };
    std::string text = line(100.0);
    for (int k = 0; k < 63; ++k) text += line(5.0 + 0.001 * k);
    text += line(100.1);  // the 63 were wrong, for all that they agreed
    for (int k = 0; k < 70; ++k) text += line(1.0 + 0.001 * k);
    text += line(0.5);  // a small step is held again
    const auto events = decode_text(decoder, text);
    REQUIRE(events.size() == 1 + 63 + 1 + 70 + 1);
    for (std::size_t k = 1; k <= 63; ++k) REQUIRE(events[k].t.us == 100'000'000);
    for (std::size_t k = 64; k < 65 + 63; ++k) REQUIRE(events[k].t.us == 100'100'000);
    for (std::size_t k = 63; k < 70; ++k)
      CHECK(events[65 + k].t.us == 1'000'000 + 1'000 * static_cast<std::int64_t>(k));
    CHECK(events.back().t.us == 1'069'000);
    CHECK(decoder.faults().time_backwards == 63 + 63 + 1);
    CHECK(decoder.faults().gaps == 1);
  }

  TEST_CASE("stamps far back that do not agree, and steps back of two seconds, move no clock") {
    TextEventDecoder decoder(240, 180);
    std::string scattered = "1000 1 1 1\n", near = "1000 1 1 1\n";
    for (int k = 0; k < 200; ++k) {
      scattered += k % 2 == 0 ? "10 1 1 1\n" : "500 1 1 1\n";
      near += "998 1 1 1\n";
    }
    for (const std::string& text : {scattered, near})
      for (const Event& e : decode_text(decoder, text)) REQUIRE(e.t.us == 1'000'000'000);
    CHECK(decoder.faults().time_backwards == 400);
    CHECK(decoder.faults().gaps == 0);
  }

  TEST_CASE("two damaged stamps that agree far ahead hold those behind them for 64 and no longer") {
    TextEventDecoder decoder(240, 180);
    std::string text = "0.1 1 1 1\n9000 1 1 1\n9000 1 1 1\n";
    for (int k = 0; k < 100; ++k) text += "0.2 2 2 1\n";
    const auto events = decode_text(decoder, text);
    REQUIRE(events.size() == 103);
    CHECK(events[3 + 62].t.us == 9'000'000'000);
    CHECK(events[3 + 63].t.us == 200'000);
    CHECK(events.back().t.us == 200'000);
  }

  TEST_CASE("one stamp far ahead costs its line, and those behind it keep their own") {
    TextEventDecoder decoder(240, 180);
    const auto events = decode_text(decoder, "0.1 1 1 1\n1000 2 1 1\n0.2 3 1 1\n0.3 4 1 1\n");
    REQUIRE(events.size() == 3);
    CHECK(events[1].x_px == 3);
    CHECK(events[1].t.us == 200000);
    CHECK(events[2].t.us == 300000);
    CHECK(decoder.faults().malformed == 1);
    CHECK(decoder.faults().time_backwards == 0);
  }

  TEST_CASE("a silence, however long, costs no event that another one follows") {
    TextEventDecoder decoder(240, 180);
    const auto events = decode_text(decoder, "0 1 1 1\n5 2 1 1\n9 3 1 1\n9 4 1 0\n");
    REQUIRE(events.size() == 4);
    for (std::uint16_t k = 0; k < 4; ++k) CHECK(events[k].x_px == k + 1);
    CHECK(events[1].t.us == 5'000'000);
    CHECK(events[3].t.us == 9'000'000);
    CHECK(decoder.faults().before_sync == 0);
    decoder.finish();
    CHECK(decoder.faults().before_sync == 0);
    CHECK(decoder.faults().malformed == 0);
  }

  TEST_CASE("a stamp that nothing follows is not believed beyond a step, and counted") {
    TextEventDecoder decoder(240, 180);
    CHECK(decode_text(decoder, "0 1 1 1\n0.131072 2 1 1\n0.262145 3 1 1\n").size() == 2);
    decoder.finish();
    decoder.finish();
    CHECK(decoder.faults().before_sync == 1);
  }

  TEST_CASE("a line without end is malformed once, whatever its length") {
    TextEventDecoder decoder(240, 180);
    const std::string endless(100'000, '1');
    CHECK(decode_text(decoder, endless).empty());
    CHECK(decode_text(decoder, endless + "\n0.1 1 2 1\n").size() == 1);
    CHECK(decoder.faults().malformed == 1);
  }

  TEST_CASE("after a gap the rest of the cut line is skipped") {
    TextEventDecoder decoder(240, 180);
    CHECK(decode_text(decoder, "0.1 1 2 1\n0.2 3").size() == 1);
    decoder.resynchronise();
    const auto events = decode_text(decoder, "5 6 1\n0.2 7 8 0\n");
    REQUIRE(events.size() == 1);
    CHECK(events[0].x_px == 7);
    CHECK(decoder.faults().malformed == 0);
    CHECK(decoder.faults().gaps == 1);
  }

  TEST_CASE("a line that the end of the stream cuts is malformed, once") {
    TextEventDecoder decoder(240, 180);
    CHECK(decode_text(decoder, "0.1 1 2 1\n0.2 3").size() == 1);
    decoder.finish();
    decoder.finish();
    CHECK(decoder.faults().malformed == 1);
  }
}
