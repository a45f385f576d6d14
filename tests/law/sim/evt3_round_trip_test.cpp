#include <cstdint>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "drivers/decode/evt3_decoder.hpp"
#include "pled_vins/sim/evt3_encoder.hpp"

using namespace pled;
using namespace pled::sim;

namespace {

constexpr int kWidth = 240, kHeight = 180;

/// Bursts in single rows, so that vectors occur, between long pauses.
std::vector<Event> random_events(std::uint64_t seed, std::size_t count) {
  std::mt19937_64 random{seed};
  std::vector<Event> events;
  std::int64_t t_us = 0;
  while (events.size() < count) {
    t_us += random() % 50 == 0 ? static_cast<std::int64_t>(random() % 700000)
                               : static_cast<std::int64_t>(random() % 20);
    const auto y = static_cast<std::uint16_t>(random() % kHeight);
    const auto polarity = random() % 2 == 0 ? Polarity::kOff : Polarity::kOn;
    const bool burst = random() % 3 == 0;
    for (std::uint64_t x = random() % kWidth; x < kWidth; x += 1 + random() % 4) {
      events.push_back({{t_us}, static_cast<std::uint16_t>(x), y, polarity});
      if (!burst) break;
    }
  }
  return events;
}

}  // namespace

TEST_SUITE("sim.evt3_round_trip") {
  TEST_CASE("decoding what was encoded gives the same events, past the wrap of the clock") {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      CAPTURE(seed);
      const std::vector<Event> sent = random_events(seed, 80000);
      REQUIRE(sent.back().t.us > (std::int64_t{1} << 24));  // wraps at least once
      Evt3Encoder encoder{kWidth};
      std::vector<std::byte> bytes;
      encoder.encode(std::span(sent).first(12345), bytes);  // in two parts
      encoder.encode(std::span(sent).subspan(12345), bytes);

      Evt3Decoder decoder{kWidth, kHeight};
      std::vector<Event> got(sent.size() + EventDecoder::kMinOutput);
      std::size_t events = 0;
      for (std::size_t at = 0; at < bytes.size();) {
        const DecodeStep step =
            decoder.decode(std::span(bytes).subspan(at), std::span(got).subspan(events));
        REQUIRE(step.bytes_consumed > 0);
        at += step.bytes_consumed;
        events += step.events;
      }
      REQUIRE(events == sent.size());
      std::size_t different = 0;
      for (std::size_t i = 0; i < events; ++i) {
        if (got[i].t != sent[i].t || got[i].x_px != sent[i].x_px || got[i].y_px != sent[i].y_px ||
            got[i].polarity != sent[i].polarity)
          ++different;
      }
      CHECK(different == 0);
      const DecoderFaults& faults = decoder.faults();
      CHECK(faults.outside_sensor + faults.time_backwards + faults.malformed + faults.before_sync +
                faults.gaps ==
            0);
    }
  }
}
