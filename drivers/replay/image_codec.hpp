#pragma once

#include <cstdint>
#include <span>

#include "drivers/replay/image_bytes.hpp"
#include "drivers/replay/message.hpp"

namespace pled::replay {

struct ImageSize {
  int width_px = 0;
  int height_px = 0;
  constexpr bool operator==(const ImageSize&) const noexcept = default;
};

/// What one image is decoded into. Everything is the caller's memory.
struct DecodeTarget {
  ImageSize max;                   ///< larger images are refused before anything is allocated
  bool exact = false;              ///< so are smaller ones
  bool header_only = false;        ///< stop when the size is known
  std::span<std::uint8_t> pixels;  ///< row-major, stride = width; max.width * max.height
  std::span<std::uint8_t> row;     ///< scratch of max.width * 3
  std::span<std::uint8_t*> rows;   ///< scratch of max.height
  std::span<std::byte> arena;      ///< memory for the PNG library
};

/// Grey of a colour, ITU-R BT.601 luma: 0.299 R + 0.587 G + 0.114 B in 16-bit fixed point.
[[nodiscard]] constexpr std::uint8_t luma(std::uint32_t r, std::uint32_t g,
                                          std::uint32_t b) noexcept {
  return static_cast<std::uint8_t>((19595U * r + 38470U * g + 7471U * b + 32768U) >> 16);
}

/// Decode one image whose bytes begin at `in`. Errors: kTruncated, kCorrupt,
/// kTooLarge, kUnsupported; `message` says what the library said.
[[nodiscard]] Result<ImageSize> decode_png(ImageBytes& in, const DecodeTarget& target,
                                           Message& message) noexcept;
[[nodiscard]] Result<ImageSize> decode_jpeg(ImageBytes& in, const DecodeTarget& target,
                                            Message& message) noexcept;

/// False, with words, when the declared size is not in 1..max, or not `max` if that is exact.
[[nodiscard]] bool size_is_allowed(std::uint32_t width, std::uint32_t height,
                                   const DecodeTarget& target, Message& message) noexcept;

}  // namespace pled::replay
