#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "drivers/replay/image_codec.hpp"

namespace pled::replay {

/// Reads PNG and JPEG files as 8-bit grey into the caller's memory: colour
/// becomes luma, 16 bits are scaled down. The kind is told by the first bytes,
/// not by the name. Allocates at construction; the JPEG library alone allocates
/// while it decodes, and gives everything back.
class ImageReader {
 public:
  /// Images up to `max` are read, larger ones refused; with `exact`, smaller ones too.
  explicit ImageReader(ImageSize max, bool exact = false);

  /// Decodes a file into the front of `pixels` (at least max.width * max.height),
  /// row-major, stride = width. Errors: File::open's, kTruncated, kCorrupt,
  /// kTooLarge, kUnsupported; `pixels` is then undefined. last_message() has words.
  [[nodiscard]] Result<ImageSize> read(const char* path, std::span<std::uint8_t> pixels) noexcept;

  /// The size that a file declares. Errors: as read().
  [[nodiscard]] Result<ImageSize> probe(const char* path) noexcept;

  /// What was wrong with the last image, without its name.
  [[nodiscard]] std::string_view last_message() const noexcept { return message_.text(); }

 private:
  [[nodiscard]] Result<ImageSize> decode(const char* path, DecodeTarget& target) noexcept;

  ImageSize max_;
  bool exact_;
  std::unique_ptr<ImageBytes> in_;
  std::vector<std::uint8_t> row_;
  std::vector<std::uint8_t*> rows_;
  std::vector<std::byte> arena_;
  Message message_;
};

}  // namespace pled::replay
