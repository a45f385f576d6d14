#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace pled {

/// Pixels somebody else owns: height rows of width values, row-major, `stride`
/// values from one row to the next.
template <typename T>
struct ImageView {
  T* data = nullptr;
  int width = 0;
  int height = 0;
  int stride = 0;

  [[nodiscard]] constexpr bool empty() const noexcept { return data == nullptr; }
  [[nodiscard]] constexpr T* row(int y) const noexcept {
    return data + static_cast<std::ptrdiff_t>(y) * stride;
  }
  [[nodiscard]] constexpr T& at(int y, int x) const noexcept { return row(y)[x]; }
  constexpr operator ImageView<const T>() const noexcept { return {data, width, height, stride}; }
};

}  // namespace pled
