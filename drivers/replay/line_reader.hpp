#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>

#include "drivers/replay/file.hpp"

namespace pled::replay {

/// What some editors put before a text; no part of it.
inline constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";

/// The lines of a text file, one at a time, through one buffer of fixed size.
class LineReader {
 public:
  static constexpr std::size_t kBufferBytes = 64 * 1024;

  /// Allocates the buffer; nothing is allocated later. Errors: as File::open.
  [[nodiscard]] static Result<LineReader> open(const char* path);

  /// The next line that carries data: without its end, blanks at its end, blank
  /// lines and '#' lines. Valid until the next call. Errors: kEndOfStream,
  /// kIoFailure, kTooLarge (a line longer than the buffer, skipped; call again).
  [[nodiscard]] Result<std::string_view> next() noexcept;

  /// Number of the line given last, from 1.
  [[nodiscard]] std::int64_t line_number() const noexcept { return line_number_; }
  /// Bytes read so far, and in the file.
  [[nodiscard]] std::int64_t position() const noexcept { return position_; }
  [[nodiscard]] std::int64_t size() const noexcept { return file_.size(); }

 private:
  [[nodiscard]] Result<std::string_view> next_raw() noexcept;
  [[nodiscard]] Result<void> refill() noexcept;

  File file_;
  std::unique_ptr<char[]> buffer_;
  std::size_t begin_ = 0;  ///< first byte not given yet
  std::size_t end_ = 0;    ///< one past the last byte read
  bool at_end_ = false;
  std::int64_t line_number_ = 0;
  std::int64_t position_ = 0;
};

}  // namespace pled::replay
