#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/hal/event_source.hpp"

namespace pled {

/// Turns an event source's chunks into spans of events in time order, as far as
/// they are asked for. Fixed memory: one batch of decoded events.
class EventFeed {
 public:
  EventFeed() = default;
  /// Neither is owned; both outlive the feed's use.
  void connect(EventSource& source, EventDecoder& decoder) noexcept;

  /// The next events with t <= `until`, oldest first, at most one batch; empty
  /// when there are none left up to then. The span is valid until the next call.
  [[nodiscard]] std::span<const Event> next(Timestamp until) noexcept;
  /// True once the source has ended or broken and everything was handed out.
  [[nodiscard]] bool ended() const noexcept { return ended_ && begin_ == end_; }
  /// Why the source broke, if it did not end by itself.
  [[nodiscard]] std::optional<Error> failure() const noexcept { return failure_; }
  [[nodiscard]] const EventDecoder* decoder() const noexcept { return decoder_; }

 private:
  bool refill() noexcept;

  EventSource* source_ = nullptr;
  EventDecoder* decoder_ = nullptr;
  std::array<Event, 8192> batch_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::span<const std::byte> chunk_;
  bool holds_chunk_ = false;
  bool ended_ = true;
  std::optional<Error> failure_;
};

}  // namespace pled
