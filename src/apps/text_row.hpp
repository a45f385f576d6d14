#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "src/apps/output_file.hpp"

namespace pled::apps {

/// One line of a text table, put together without allocation. The caller's columns
/// fit: Capacity holds the longest line of finite values below 1e15.
template <std::size_t Capacity>
class TextRow {
 public:
  void stamp(std::int64_t stamp_ns) noexcept {
    if (Capacity - size_ < 32) return overflow();
    size_ += format_stamp(stamp_ns, text_.data() + size_);
  }
  void text(std::string_view word) noexcept {
    if (Capacity - size_ < word.size()) return overflow();
    for (const char c : word) text_[size_++] = c;
  }
  /// Fixed decimals; NaN leaves the field empty.
  void number(double value, int decimals) noexcept {
    if (std::isnan(value)) return;
    finish(std::to_chars(end(), limit(), value, std::chars_format::fixed, decimals));
  }
  /// So many digits that the same number is read again; NaN leaves the field empty.
  void exact_number(double value) noexcept {
    if (std::isnan(value)) return;
    finish(std::to_chars(end(), limit(), value));
  }
  void count(std::uint64_t value) noexcept { finish(std::to_chars(end(), limit(), value)); }

  /// False when the line did not fit.
  [[nodiscard]] bool ok() const noexcept { return !overflowed_; }
  [[nodiscard]] std::string_view view() const noexcept { return {text_.data(), size_}; }

 private:
  void overflow() noexcept { overflowed_ = true; }
  [[nodiscard]] char* end() noexcept { return text_.data() + size_; }
  [[nodiscard]] char* limit() noexcept { return text_.data() + Capacity; }
  void finish(std::to_chars_result result) noexcept {
    if (result.ec != std::errc{}) return overflow();
    size_ = static_cast<std::size_t>(result.ptr - text_.data());
  }

  std::array<char, Capacity> text_{};
  std::size_t size_ = 0;
  bool overflowed_ = false;
};

}  // namespace pled::apps
