#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/decode/aedat2_event_decoder.hpp"
#include "drivers/decode/aedat2_frame.hpp"
#include "drivers/decode/aedat2_imu.hpp"
#include "fuzz/decode_in_chunks.hpp"

/// Any bytes: all are consumed, no event is outside the sensor, time never decreases, and the
/// collectors of samples and frames take every record. The first byte chooses the chunk
/// length.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr int kWidth = 240;
  constexpr int kHeight = 180;
  const std::size_t chunk = 1U + data[0];
  const std::span<const std::byte> bytes{reinterpret_cast<const std::byte*>(data + 1), size - 1};
  pled::Aedat2EventDecoder decoder(kWidth, kHeight);
  pled::fuzz::decode_in_chunks(decoder, bytes, chunk, kWidth, kHeight);

  constexpr int kSide = 3;
  std::array<std::uint16_t, 2 * kSide * kSide> samples{};
  std::array<std::uint8_t, kSide * kSide> pixels{};
  pled::Aedat2Records records;
  pled::Aedat2ImuCollector imu({});
  pled::Aedat2FrameCollector frames(kSide, kSide, samples);
  std::span<const std::byte> rest = bytes;
  while (const auto record = records.next(rest)) {
    (void)imu.take(*record);
    if (frames.take(*record)) frames.render(pixels);
  }
  return 0;
}
