#pragma once

#include <array>
#include <charconv>
#include <string>

namespace pled {

/// The shortest text that reads back as the same number.
template <typename T>
[[nodiscard]] std::string number_text(T value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

}  // namespace pled
