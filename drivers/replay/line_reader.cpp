#include "drivers/replay/line_reader.hpp"

#include <cstring>
#include <utility>

#include "drivers/decode/decimal.hpp"

namespace pled::replay {

Result<LineReader> LineReader::open(const char* path) {
  auto file = File::open(path);
  if (!file.ok()) return file.error();
  LineReader reader;
  reader.file_ = std::move(file).value();
  reader.buffer_ = std::make_unique<char[]>(kBufferBytes);
  return reader;
}

Result<std::string_view> LineReader::next() noexcept {
  while (true) {
    const auto raw = next_raw();
    if (!raw.ok()) return raw.error();
    std::string_view line = trimmed_line(raw.value());
    if (line_number_ == 1 && line.starts_with(kUtf8Mark)) line.remove_prefix(kUtf8Mark.size());
    if (!is_blank_or_comment(line)) return line;
  }
}

Result<std::string_view> LineReader::next_raw() noexcept {
  bool too_long = false;
  while (true) {
    char* const text = buffer_.get() + begin_;
    const std::size_t held = end_ - begin_;
    const void* const found = held == 0 ? nullptr : std::memchr(text, '\n', held);
    if (found != nullptr || (at_end_ && held > 0)) {
      const std::size_t length =
          found != nullptr ? static_cast<std::size_t>(static_cast<const char*>(found) - text)
                           : held;
      begin_ += found != nullptr ? length + 1 : length;
      ++line_number_;
      if (too_long) return ErrorCode::kTooLarge;
      return std::string_view{text, length};
    }
    if (at_end_) {
      if (!too_long) return ErrorCode::kEndOfStream;
      ++line_number_;
      return ErrorCode::kTooLarge;
    }
    if (held == kBufferBytes) {
      too_long = true;
      begin_ = end_;
    }
    PLED_TRY(refill());
  }
}

/// Moves what is left to the front and reads behind it.
Result<void> LineReader::refill() noexcept {
  std::memmove(buffer_.get(), buffer_.get() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  const auto got =
      file_.read({reinterpret_cast<std::byte*>(buffer_.get() + end_), kBufferBytes - end_});
  if (!got.ok()) return got.error();
  at_end_ = got.value() == 0;
  end_ += got.value();
  position_ += static_cast<std::int64_t>(got.value());
  return {};
}

}  // namespace pled::replay
