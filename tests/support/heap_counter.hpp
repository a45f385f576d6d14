#pragma once

#include <cstddef>

/// The heap of a test that links support/heap_counter.cpp, by whomever it is used: C, C++, OpenCV.
namespace pled::support {

/// Whether the heap is counted; tried out, for a hook that does not work finds nothing. Says so
/// where a sanitizer has an allocator of its own.
[[nodiscard]] bool heap_is_counted();

[[nodiscard]] std::size_t allocations() noexcept;  ///< since the program began
[[nodiscard]] std::size_t live_bytes() noexcept;   ///< not given back
[[nodiscard]] std::size_t peak_bytes() noexcept;   ///< most live_bytes() since forget_peak()
void forget_peak() noexcept;

}  // namespace pled::support
