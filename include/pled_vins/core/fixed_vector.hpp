#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

#include "pled_vins/core/check.hpp"

namespace pled {

/// A sequence with its storage inside and a size up to Capacity. Items are
/// trivially copyable, so the whole crosses threads by copy. A full vector
/// refuses: losing an item is the caller's decision.
template <typename T, std::size_t Capacity>
class FixedVector {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  using value_type = T;

  [[nodiscard]] static constexpr std::size_t capacity() noexcept { return Capacity; }
  [[nodiscard]] constexpr std::size_t size() const noexcept { return size_; }
  [[nodiscard]] constexpr bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] constexpr bool full() const noexcept { return size_ == Capacity; }

  /// False when full; the vector is unchanged.
  [[nodiscard]] constexpr bool push_back(const T& item) noexcept {
    if (full()) return false;
    items_[size_++] = item;
    return true;
  }
  constexpr void pop_back() noexcept {
    PLED_CHECK(size_ > 0);
    --size_;
  }
  constexpr void clear() noexcept { size_ = 0; }
  /// Shrinks or grows; new items are value-initialised. False past capacity.
  [[nodiscard]] constexpr bool resize(std::size_t size) noexcept {
    if (size > Capacity) return false;
    for (std::size_t i = size_; i < size; ++i) items_[i] = T{};
    size_ = size;
    return true;
  }
  /// Removes item i; later items move one place forward. O(size).
  constexpr void erase(std::size_t i) noexcept {
    PLED_CHECK(i < size_);
    for (std::size_t k = i + 1; k < size_; ++k) items_[k - 1] = items_[k];
    --size_;
  }

  [[nodiscard]] constexpr T& operator[](std::size_t i) noexcept {
    PLED_CHECK(i < size_);
    return items_[i];
  }
  [[nodiscard]] constexpr const T& operator[](std::size_t i) const noexcept {
    PLED_CHECK(i < size_);
    return items_[i];
  }
  [[nodiscard]] constexpr T& front() noexcept { return (*this)[0]; }
  [[nodiscard]] constexpr const T& front() const noexcept { return (*this)[0]; }
  [[nodiscard]] constexpr T& back() noexcept { return (*this)[size_ - 1]; }
  [[nodiscard]] constexpr const T& back() const noexcept { return (*this)[size_ - 1]; }

  [[nodiscard]] constexpr T* data() noexcept { return items_.data(); }
  [[nodiscard]] constexpr const T* data() const noexcept { return items_.data(); }
  [[nodiscard]] constexpr T* begin() noexcept { return items_.data(); }
  [[nodiscard]] constexpr T* end() noexcept { return items_.data() + size_; }
  [[nodiscard]] constexpr const T* begin() const noexcept { return items_.data(); }
  [[nodiscard]] constexpr const T* end() const noexcept { return items_.data() + size_; }
  [[nodiscard]] constexpr std::span<T> span() noexcept { return {items_.data(), size_}; }
  [[nodiscard]] constexpr std::span<const T> span() const noexcept {
    return {items_.data(), size_};
  }

 private:
  std::array<T, Capacity> items_{};
  std::size_t size_ = 0;
};

}  // namespace pled
