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
///
/// Time goes back where the events' clock was set back. Events behind that are given when who asks
/// has gone back as well, or asks again; what is left from before, too far ahead ever to be asked
/// for, is passed over.
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
  [[nodiscard]] bool refill() noexcept;
  void find_run_end() noexcept;
  [[nodiscard]] bool another_run_follows() noexcept;
  [[nodiscard]] bool is_left_behind(Timestamp t, Timestamp until) noexcept;
  [[nodiscard]] bool must_wait(Timestamp t, Timestamp until) noexcept;

  EventSource* source_ = nullptr;
  EventDecoder* decoder_ = nullptr;
  std::array<Event, 8192> batch_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::size_t run_end_ = 0;          ///< up to here time does not go back
  Timestamp until_{INT64_MIN};       ///< of the last call
  std::optional<Timestamp> left_;    ///< the same, before who asks went back
  std::optional<Timestamp> given_;   ///< the last event handed out
  std::optional<Timestamp> waited_;  ///< `until`, when events behind a step back were met
  std::span<const std::byte> chunk_;
  bool holds_chunk_ = false;
  bool ended_ = true;
  std::optional<Error> failure_;
};

}  // namespace pled
