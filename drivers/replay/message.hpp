#pragma once

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>

namespace pled::replay {

/// A line of words for people, in memory of its own: no allocation on the data path.
class Message {
 public:
  template <typename... Args>
  void set(const char* format, Args... args) noexcept {
    const int n = std::snprintf(text_.data(), text_.size(), format, args...);
    const int room = static_cast<int>(text_.size()) - 1;
    size_ = static_cast<std::size_t>(std::clamp(n, 0, room));
  }
  void set(const char* text) noexcept { set("%s", text); }
  [[nodiscard]] std::string_view text() const noexcept { return {text_.data(), size_}; }
  [[nodiscard]] const char* c_str() const noexcept { return text_.data(); }

 private:
  std::array<char, 512> text_{};
  std::size_t size_ = 0;
};

}  // namespace pled::replay
