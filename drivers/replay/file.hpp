#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "pled_vins/core/result.hpp"

namespace pled::replay {

/// A file opened for reading; closed with the object. Never allocates.
class File {
 public:
  File() = default;
  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File();

  /// Never waits. Errors: kNotFound, kPermission, kInvalidArgument (a folder, a pipe, a
  /// device), kIoFailure; detail = errno.
  [[nodiscard]] static Result<File> open(const char* path) noexcept;

  /// Fills as much of `out` as the file still has; 0 at its end. Errors: kIoFailure.
  [[nodiscard]] Result<std::size_t> read(std::span<std::byte> out) noexcept;
  /// The next read begins `offset` bytes after the beginning. Errors: kIoFailure.
  [[nodiscard]] Result<void> seek(std::int64_t offset) noexcept;
  /// Bytes when it was opened.
  [[nodiscard]] std::int64_t size() const noexcept { return size_; }

 private:
  int descriptor_ = -1;
  std::int64_t size_ = 0;
};

/// Why a failed open failed.
[[nodiscard]] std::string_view open_reason(Error error) noexcept;
/// "cannot open /some/file: permission denied": words for a failed open.
[[nodiscard]] std::string open_failure(const std::string& path, Error error);

}  // namespace pled::replay
