#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <span>

#include "drivers/decode/evt3_decoder.hpp"

/// Any bytes: all are consumed, no event is outside the sensor, time never
/// decreases. The first byte chooses the chunk length.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr int kWidth = 240;
  constexpr int kHeight = 180;
  const std::size_t chunk = 1U + data[0];
  std::span<const std::byte> rest{reinterpret_cast<const std::byte*>(data + 1), size - 1};
  pled::Evt3Decoder decoder(kWidth, kHeight);
  std::array<pled::Event, pled::EventDecoder::kMinOutput> out{};
  std::int64_t last_us = std::numeric_limits<std::int64_t>::min();
  while (!rest.empty()) {
    const auto part = rest.first(rest.size() < chunk ? rest.size() : chunk);
    const pled::DecodeStep step = decoder.decode(part, out);
    if (step.bytes_consumed == 0 || step.bytes_consumed > part.size()) std::abort();
    for (const pled::Event& event : std::span{out}.first(step.events)) {
      if (event.x_px >= kWidth || event.y_px >= kHeight || event.t.us < last_us) std::abort();
      last_us = event.t.us;
    }
    rest = rest.subspan(step.bytes_consumed);
  }
  return 0;
}
