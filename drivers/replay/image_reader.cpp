#include "drivers/replay/image_reader.hpp"

#include <string>

#include "pled_vins/core/check.hpp"

namespace pled::replay {
namespace {

/// zlib's window and tables, the library's own state, and room for text chunks.
constexpr std::size_t kArenaBytes = std::size_t{256} * 1024;
/// Row buffers of the PNG library: up to 8 bytes a pixel, current and previous, with slack.
constexpr std::size_t kArenaBytesPerColumn = 32;

}  // namespace

Result<ImageSize> ImageReader::read(const char* path, std::span<std::uint8_t> pixels) noexcept {
  PLED_CHECK(pixels.size() >=
             static_cast<std::size_t>(max_.width_px) * static_cast<std::size_t>(max_.height_px));
  DecodeTarget target;
  target.pixels = pixels;
  return decode(path, target);
}

Result<ImageSize> ImageReader::probe(const char* path) noexcept {
  DecodeTarget target;
  target.header_only = true;
  return decode(path, target);
}

ImageReader::ImageReader(ImageSize max, bool exact)
    : max_(max),
      exact_(exact),
      in_(std::make_unique<ImageBytes>()),
      row_(static_cast<std::size_t>(max.width_px) * 3),
      rows_(static_cast<std::size_t>(max.height_px)),
      arena_(kArenaBytes + kArenaBytesPerColumn * static_cast<std::size_t>(max.width_px)) {}

Result<ImageSize> ImageReader::decode(const char* path, DecodeTarget& target) noexcept {
  target.max = max_;
  target.exact = exact_;
  target.row = row_;
  target.rows = rows_;
  target.arena = arena_;
  message_.set("unreadable");
  if (const auto opened = in_->open(path); !opened.ok()) {
    const std::string_view why = open_reason(opened.error());
    message_.set("%.*s", static_cast<int>(why.size()), why.data());
    return opened.error();
  }
  constexpr std::byte kPngMagic{0x89};
  constexpr std::byte kJpegMagic{0xFF};
  const std::span<const std::byte> head = in_->peek();
  Result<ImageSize> size = ErrorCode::kCorrupt;
  if (head.empty()) {
    message_.set("the file is empty");
    size = ErrorCode::kTruncated;
  } else if (head[0] == kPngMagic) {
    size = decode_png(*in_, target, message_);
  } else if (head[0] == kJpegMagic) {
    size = decode_jpeg(*in_, target, message_);
  } else {
    message_.set("neither a PNG nor a JPEG image");
  }
  in_->close();
  return size;
}

bool size_is_allowed(std::uint32_t width, std::uint32_t height, const DecodeTarget& target,
                     Message& message) noexcept {
  const auto max_width = static_cast<std::uint32_t>(target.max.width_px);
  const auto max_height = static_cast<std::uint32_t>(target.max.height_px);
  const bool fits = width >= 1 && height >= 1 && width <= max_width && height <= max_height;
  if (fits && (!target.exact || (width == max_width && height == max_height))) return true;
  message.set(target.exact ? "%ux%u pixels; the recording's images have %ux%u"
                           : "%ux%u pixels; at most %ux%u can be read",
              width, height, max_width, max_height);
  return false;
}

}  // namespace pled::replay
