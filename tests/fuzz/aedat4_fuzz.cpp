#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "drivers/decode/aedat4_event_decoder.hpp"
#include "drivers/decode/aedat4_packets.hpp"
#include "drivers/replay/aedat4_header.hpp"
#include "fuzz/decode_in_chunks.hpp"

namespace {

constexpr int kWidth = 240;
constexpr int kHeight = 180;

void decode(std::span<const std::byte> bytes, std::size_t chunk) {
  pled::Aedat4EventDecoder decoder(kWidth, kHeight);
  pled::fuzz::decode_in_chunks(decoder, bytes, chunk, kWidth, kHeight);
}

/// Touches every byte, for the sanitizer to see.
[[nodiscard]] unsigned sum_of(std::span<const std::byte> bytes) {
  unsigned sum = 0;
  for (const std::byte byte : bytes) sum += std::to_integer<unsigned>(byte);
  return sum;
}

}  // namespace

/// Any bytes as a packet of each kind, as the head of a file and as events: nothing outside is
/// read, no event is outside the sensor, time never decreases. The first byte chooses the
/// chunk length.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::byte> bytes{reinterpret_cast<const std::byte*>(data + 1), size - 1};
  decode(bytes, 1U + data[0]);
  if (const auto events = pled::aedat4_events(bytes)) decode(*events, 1U + data[0]);
  if (const auto samples = pled::Aedat4ImuPacket::read(bytes)) {
    for (std::size_t i = 0; i < samples->size(); ++i) {
      const auto sample = samples->sample(i);
      if (sample && !(sample->gyro_radps[0] == sample->gyro_radps[0])) std::abort();
    }
  }
  if (const auto frame = pled::aedat4_frame(bytes))
    if (sum_of(frame->pixels) > frame->pixels.size() * 255) std::abort();
  (void)pled::aedat4_trigger_count(bytes);
  (void)pled::aedat4_table_size(bytes);
  (void)pled::replay::parse_aedat4_header(bytes);
  return 0;
}
