#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <utility>

#include "drivers/replay/file.hpp"

namespace pled::replay {

/// An image file's bytes through one buffer, for the image libraries' callbacks.
class ImageBytes {
 public:
  /// Begins the given file. Errors: as File::open.
  [[nodiscard]] Result<void> open(const char* path) noexcept {
    auto file = File::open(path);
    if (!file.ok()) return file.error();
    file_ = std::move(file).value();
    begin_ = end_ = 0;
    ended_ = false;
    failed_ = false;
    return {};
  }
  void close() noexcept { file_ = File{}; }

  /// The bytes at hand, at least one; empty at the end of the file. Not consumed.
  [[nodiscard]] std::span<const std::byte> peek() noexcept {
    if (begin_ == end_ && !ended_) fill();
    return std::span{buffer_}.subspan(begin_, end_ - begin_);
  }
  void consume(std::size_t bytes) noexcept { begin_ += std::min(bytes, end_ - begin_); }

  /// Fills `out` whole, or says false: the file ended first.
  [[nodiscard]] bool read_exactly(std::span<std::byte> out) noexcept {
    while (!out.empty()) {
      const auto held = peek();
      if (held.empty()) return false;
      const std::size_t n = std::min(held.size(), out.size());
      std::memcpy(out.data(), held.data(), n);
      consume(n);
      out = out.subspan(n);
    }
    return true;
  }

  /// The end of the file was met where more was asked for.
  [[nodiscard]] bool ended() const noexcept { return ended_; }
  /// Reading failed, which looks like the end.
  [[nodiscard]] bool failed() const noexcept { return failed_; }

 private:
  void fill() noexcept {
    const auto got = file_.read(buffer_);
    begin_ = 0;
    end_ = got.ok() ? got.value() : 0;
    failed_ = !got.ok();
    ended_ = end_ == 0;
  }

  File file_;
  std::array<std::byte, std::size_t{16} * 1024> buffer_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  bool ended_ = false;
  bool failed_ = false;
};

}  // namespace pled::replay
