#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "pled_vins/core/messages.hpp"

namespace pled {

/// Bounds the work that a burst of events makes: in each millisecond of their own time the first so
/// many are let through, the rest is counted. By stamps, not by a clock, so a replay sheds the same
/// events every time.
class RateLimit {
 public:
  /// @param rate_mevps  millions a second, > 0
  explicit RateLimit(double rate_mevps) noexcept
      : per_slot_(static_cast<std::uint64_t>(rate_mevps * 1e3)) {}

  /// Calls `take` with the runs of `events` (in time order) that are let through.
  template <typename Take>
  void pass(std::span<const Event> events, const Take& take) noexcept {
    while (!events.empty()) {
      const std::int64_t slot = events.front().t.us >> kSlotLog2_us;
      const Event* end =
          std::partition_point(events.data(), events.data() + events.size(),
                               [&](const Event& e) { return e.t.us >> kSlotLog2_us <= slot; });
      const auto n = static_cast<std::size_t>(end - events.data());
      if (slot != slot_) {
        slot_ = slot;
        taken_ = 0;
      }
      const auto room = static_cast<std::size_t>(std::min<std::uint64_t>(n, per_slot_ - taken_));
      taken_ += room;
      shed_ += n - room;
      if (room > 0) take(events.first(room));
      events = events.subspan(n);
    }
  }

  [[nodiscard]] std::uint64_t shed() const noexcept { return shed_; }

 private:
  static constexpr int kSlotLog2_us = 10;

  std::uint64_t per_slot_;
  std::int64_t slot_ = INT64_MIN;
  std::uint64_t taken_ = 0;
  std::uint64_t shed_ = 0;
};

}  // namespace pled
