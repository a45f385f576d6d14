#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <span>

#include "pled_vins/hal/event_source.hpp"

namespace pled::fuzz {

/// Gives a decoder any bytes in chunks of `chunk` and aborts unless all are consumed, no event is
/// outside the sensor, and time never goes back by less than what counts as a clock set back.
inline void decode_in_chunks(EventDecoder& decoder, std::span<const std::byte> rest,
                             std::size_t chunk, int width_px, int height_px) {
  constexpr std::int64_t kSetBack_us = 2'000'000;
  std::array<Event, EventDecoder::kMinOutput> out{};
  std::int64_t last_us = std::numeric_limits<std::int64_t>::min();
  while (!rest.empty()) {
    const auto part = rest.first(rest.size() < chunk ? rest.size() : chunk);
    const DecodeStep step = decoder.decode(part, out);
    if (step.bytes_consumed == 0 || step.bytes_consumed > part.size()) std::abort();
    for (const Event& event : std::span{out}.first(step.events)) {
      if (event.x_px >= width_px || event.y_px >= height_px) std::abort();
      if (event.t.us < last_us && event.t.us >= last_us - kSetBack_us) std::abort();
      last_us = event.t.us;
    }
    rest = rest.subspan(step.bytes_consumed);
  }
  decoder.finish();
}

}  // namespace pled::fuzz
