#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/decode/evt3_decoder.hpp"
#include "fuzz/decode_in_chunks.hpp"

/// Any bytes, see decode_in_chunks(). The first byte chooses the chunk length.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr int kWidth = 240;
  constexpr int kHeight = 180;
  pled::Evt3Decoder decoder(kWidth, kHeight);
  pled::fuzz::decode_in_chunks(decoder, {reinterpret_cast<const std::byte*>(data + 1), size - 1},
                               1U + data[0], kWidth, kHeight);
  return 0;
}
