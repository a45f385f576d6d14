#pragma once

namespace pled {

/// Prints the broken invariant to stderr and aborts.
[[noreturn]] void check_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace pled

/// An invariant of our own code. Never used on bytes from a device or a file.
#define PLED_CHECK(cond)                                          \
  do {                                                            \
    if (!(cond)) ::pled::check_failed(#cond, __FILE__, __LINE__); \
  } while (false)
