#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace pled {

inline constexpr std::size_t kCacheLine = 64;

/// A bounded queue between exactly one writer thread and one reader thread.
/// Storage is inside; both sides are wait-free. A full ring refuses, so losing
/// data is the caller's decision and shows in the caller's code.
template <typename T, std::size_t Capacity>
class SpscRing {
  static_assert(std::is_trivially_copyable_v<T>, "items cross threads by copy");
  static_assert(Capacity > 1 && (Capacity & (Capacity - 1)) == 0, "power of two");
  static_assert(Capacity <= (std::size_t{1} << 31), "counters are 32 bits");

 public:
  [[nodiscard]] static constexpr std::size_t capacity() noexcept { return Capacity; }

  /// Writer only. False when full; the ring is unchanged.
  [[nodiscard]] bool push(const T& item) noexcept {
    const std::uint32_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == Capacity) return false;
    items_[head % Capacity] = item;
    head_.store(head + 1, std::memory_order_release);  // publishes the item
    return true;
  }

  /// Reader only. False when empty; `out` is unchanged.
  [[nodiscard]] bool pop(T& out) noexcept {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);
    if (head_.load(std::memory_order_acquire) == tail) return false;
    out = items_[tail % Capacity];
    tail_.store(tail + 1, std::memory_order_release);  // gives the slot back
    return true;
  }

  /// Reader only. The oldest item, or null when empty; valid until pop().
  [[nodiscard]] const T* peek() const noexcept {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);
    if (head_.load(std::memory_order_acquire) == tail) return nullptr;
    return &items_[tail % Capacity];
  }

  /// Either side. Exact for the caller's own end, a snapshot for the other.
  [[nodiscard]] std::size_t size() const noexcept {
    const std::uint32_t tail = tail_.load(std::memory_order_acquire);
    return head_.load(std::memory_order_acquire) - tail;
  }

 private:
  // Free-running counters: their difference is the fill, so no slot is wasted.
  alignas(kCacheLine) std::atomic<std::uint32_t> head_{0};
  alignas(kCacheLine) std::atomic<std::uint32_t> tail_{0};
  alignas(kCacheLine) std::array<T, Capacity> items_{};
};

}  // namespace pled
