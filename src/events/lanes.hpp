#pragma once

#include <cstdint>
#include <cstring>

/// Four numbers at once, in the vector types of GCC and Clang: SSE2 and NEON from one source, and
/// the results of the scalar operations to the bit.
namespace pled::lanes {

using Floats = float __attribute__((vector_size(16)));
using Doubles = double __attribute__((vector_size(16)));
using Ints = std::int32_t __attribute__((vector_size(16)));
using Unsigneds = std::uint32_t __attribute__((vector_size(16)));

template <typename To, typename From>
[[nodiscard]] inline To as(const From& from) noexcept {
  static_assert(sizeof(To) == sizeof(From));
  To to;
  std::memcpy(&to, &from, sizeof(to));
  return to;
}

[[nodiscard]] inline Floats load(const float* four) noexcept {
  Floats values;
  std::memcpy(&values, four, sizeof(values));
  return values;
}

template <int A, int B, int C, int D, typename V>
[[nodiscard]] inline V shuffle(const V& a, const V& b) noexcept {
  return __builtin_shufflevector(a, b, A, B, C, D);
}

}  // namespace pled::lanes
