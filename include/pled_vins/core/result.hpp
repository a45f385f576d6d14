#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

namespace pled {

/// What the world did to us. A caller that knows the file or device adds words.
enum class ErrorCode : std::uint8_t {
  kNone,
  kTimeout,
  kEndOfStream,
  kDisconnected,
  kNotFound,
  kPermission,
  kIoFailure,
  kTruncated,
  kCorrupt,
  kBadNumber,
  kUnsupported,
  kTooLarge,
  kInvalidArgument,
};

[[nodiscard]] constexpr std::string_view to_string(ErrorCode code) noexcept {
  switch (code) {
    case ErrorCode::kNone: return "no error";
    case ErrorCode::kTimeout: return "timed out";
    case ErrorCode::kEndOfStream: return "end of stream";
    case ErrorCode::kDisconnected: return "disconnected";
    case ErrorCode::kNotFound: return "not found";
    case ErrorCode::kPermission: return "permission denied";
    case ErrorCode::kIoFailure: return "input/output failure";
    case ErrorCode::kTruncated: return "truncated";
    case ErrorCode::kCorrupt: return "corrupt";
    case ErrorCode::kBadNumber: return "not a number";
    case ErrorCode::kUnsupported: return "unsupported";
    case ErrorCode::kTooLarge: return "too large";
    case ErrorCode::kInvalidArgument: return "invalid argument";
  }
  return "unknown";
}

/// A failure: what kind, and one integer that means something to that kind
/// (errno, line number, byte offset, required size).
struct Error {
  ErrorCode code = ErrorCode::kNone;
  std::int64_t detail = 0;
};

/// A value, or the reason there is none. Never throws, never allocates by itself.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}
  Result(Error error) noexcept : error_(error) {}
  Result(ErrorCode code) noexcept : error_(Error{code, 0}) {}

  [[nodiscard]] bool ok() const noexcept { return value_.has_value(); }
  [[nodiscard]] const T& value() const& noexcept { return *value_; }
  [[nodiscard]] T& value() & noexcept { return *value_; }
  [[nodiscard]] T&& value() && noexcept { return std::move(*value_); }
  [[nodiscard]] Error error() const noexcept { return error_; }

 private:
  std::optional<T> value_;
  Error error_{};
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) noexcept : error_(error) {}
  Result(ErrorCode code) noexcept : error_(Error{code, 0}) {}

  [[nodiscard]] bool ok() const noexcept { return error_.code == ErrorCode::kNone; }
  [[nodiscard]] Error error() const noexcept { return error_; }

 private:
  Error error_{};
};

}  // namespace pled

/// Leaves the function with the error of `expr`, if it has one.
#define PLED_TRY(expr)                                           \
  do {                                                           \
    const auto& pled_try_result_ = (expr);                       \
    if (!pled_try_result_.ok()) return pled_try_result_.error(); \
  } while (false)
