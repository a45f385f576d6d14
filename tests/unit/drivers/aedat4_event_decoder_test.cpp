#include "drivers/decode/aedat4_event_decoder.hpp"

#include <limits>

#include <doctest/doctest.h>

#include "unit/drivers/aedat4_writer.hpp"
#include "unit/drivers/evt3_words.hpp"

using namespace pled;
using namespace pled::support;

namespace {

constexpr int kWidth = 20;
constexpr int kHeight = 10;
constexpr std::int64_t kStep_us = Aedat4EventDecoder::kMaxStep_us;

Bytes joined(std::initializer_list<Bytes> records) {
  Bytes all;
  for (const Bytes& record : records) all.insert(all.end(), record.begin(), record.end());
  return all;
}

std::vector<std::int64_t> times(const std::vector<Event>& events) {
  std::vector<std::int64_t> out;
  for (const Event& event : events) out.push_back(event.t.us);
  return out;
}

/// Events at these stamps, x counting them.
Bytes at_times(const std::vector<std::int64_t>& stamps_us) {
  Bytes all;
  int x = 0;
  for (const std::int64_t t_us : stamps_us) {
    const Bytes record = event_record(t_us, x++ % kWidth, 0, 1);
    all.insert(all.end(), record.begin(), record.end());
  }
  return all;
}

}  // namespace

TEST_SUITE("drivers.aedat4_event_decoder") {
  TEST_CASE("pixel, polarity and stamp are those of the record") {
    Aedat4EventDecoder decoder(kWidth, kHeight);
    const auto events = decode_all(decoder, joined({event_record(1605537493718345, 19, 9, 1),
                                                    event_record(1605537493718346, 0, 0, 0)}));
    CHECK(same(events, {{{1605537493718345}, 19, 9, Polarity::kOn},
                        {{1605537493718346}, 0, 0, Polarity::kOff}}));
  }

  TEST_CASE("events outside the sensor are dropped and counted, negative ones too") {
    Aedat4EventDecoder decoder(kWidth, kHeight);
    const auto events = decode_all(
        decoder,
        joined({event_record(1, 1, 1, 1), event_record(2, 20, 1, 1), event_record(3, 1, 10, 1),
                event_record(4, -1, 1, 1), event_record(5, 1, -1, 1), event_record(6, 2, 2, 0)}));
    CHECK(times(events) == std::vector<std::int64_t>{1, 6});
    CHECK(decoder.faults().outside_sensor == 4);
  }

  TEST_CASE("a polarity that is none and a stamp beyond all clocks are malformed") {
    Aedat4EventDecoder decoder(kWidth, kHeight);
    const auto events =
        decode_all(decoder, joined({event_record(1, 1, 1, 2), event_record(1, 1, 1, 1),
                                    event_record(std::numeric_limits<std::int64_t>::max(), 1, 1, 1),
                                    event_record(std::numeric_limits<std::int64_t>::min(), 1, 1, 1),
                                    event_record(2, 1, 1, 1)}));
    CHECK(times(events) == std::vector<std::int64_t>{1, 2});
    CHECK(decoder.faults().malformed == 3);
  }

  TEST_CASE("a stamp that goes back is held at the last one and counted") {
    Aedat4EventDecoder decoder(kWidth, kHeight);
    const auto events = decode_all(decoder, at_times({100, 200, 150, 250, -9000000}));
    CHECK(times(events) == std::vector<std::int64_t>{100, 200, 200, 250, 250});
    CHECK(decoder.faults().time_backwards == 2);
  }

  TEST_CASE("a clock that is set back is followed after 64 stamps that agree, not before") {
    std::vector<std::int64_t> stamps{100'000'000, 100'000'000};
    std::vector<std::int64_t> expected = stamps;
    for (int k = 0; k < 100; ++k) {
      stamps.push_back(5'000'000 + k);
      expected.push_back(k < 63 ? 100'000'000 : 5'000'000 + k);
    }
    Aedat4EventDecoder decoder(kWidth, kHeight);
    CHECK(times(decode_all(decoder, at_times(stamps))) == expected);
    CHECK(decoder.faults().time_backwards == 63);
    CHECK(decoder.faults().gaps == 1);
  }

  TEST_CASE("one wild stamp is dropped and does not throw the clock, wherever it stands") {
    for (std::size_t at = 0; at < 5; ++at) {
      CAPTURE(at);
      std::vector<std::int64_t> stamps{100, 200, 300, 400, 500};
      stamps[at] += std::int64_t{1} << 40;
      Aedat4EventDecoder decoder(kWidth, kHeight);
      const auto events = decode_all(decoder, at_times(stamps));
      decoder.finish();
      // Of the first two nobody can tell which one is wild: both wait in vain.
      const std::size_t lost = at == 1 ? 2 : 1;
      CHECK(events.size() == 5 - lost);
      CHECK(events.back().t.us <= 500);
      CHECK(decoder.faults().malformed + decoder.faults().before_sync == lost);
      CHECK(decoder.faults().time_backwards == 0);
    }
  }

  TEST_CASE("a sensor that was silent loses no event") {
    Aedat4EventDecoder decoder(kWidth, kHeight);
    const std::vector<std::int64_t> stamps{0, 10, 10 + kStep_us, 5'000'000, 5'000'100, 5'000'200};
    CHECK(times(decode_all(decoder, at_times(stamps))) == stamps);
    CHECK(decoder.faults().malformed == 0);
    CHECK(decoder.faults().gaps == 0);
  }

  TEST_CASE("after lost bytes the record that was begun is forgotten") {
    Aedat4EventDecoder decoder(kWidth, kHeight);
    const Bytes bytes = at_times({1, 2, 3});
    auto events = decode_all(decoder, std::span(bytes).first(2 * 16 + 5));
    decoder.resynchronise();
    const auto rest = decode_all(decoder, at_times({4}));
    events.insert(events.end(), rest.begin(), rest.end());
    CHECK(times(events) == std::vector<std::int64_t>{1, 2, 4});
    CHECK(decoder.faults().gaps == 1);
  }

  TEST_CASE("a record that is cut by the end is malformed, and a lone event is not believed") {
    Aedat4EventDecoder decoder(kWidth, kHeight);
    const Bytes bytes = at_times({1, 2});
    CHECK(decode_all(decoder, std::span(bytes).first(31)).empty());
    decoder.finish();
    CHECK(decoder.faults().malformed == 1);
    CHECK(decoder.faults().before_sync == 1);
  }
}
