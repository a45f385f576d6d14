#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/decode/aedat4_packets.hpp"
#include "drivers/decode/event_clock.hpp"
#include "pled_vins/hal/event_source.hpp"

namespace pled {

/// The events of AEDAT 4.0 packets (aedat4_events()), one behind the other, to events.
///
/// Time: 64 bits of microseconds, as the file has them. Ours: a stamp at most kMaxStep_us
/// ahead of the last is taken at once; those that go back are EventClock's to judge. Any other,
/// and the first of all, waits for the next event and is given out when that agrees
/// with it, so that one damaged stamp cannot throw the clock: a sensor that was silent loses
/// nothing. One that stays alone is malformed; at the end of the stream it counts in
/// `before_sync`.
class Aedat4EventDecoder final : public EventDecoder {
 public:
  static constexpr std::int64_t kMaxStep_us = 131'072;

  /// Events with x in [0, width_px) and y in [0, height_px) pass.
  Aedat4EventDecoder(int width_px, int height_px) noexcept;

  DecodeStep decode(std::span<const std::byte> bytes, std::span<Event> out) noexcept override;
  void resynchronise() noexcept override;
  void finish() noexcept override;
  [[nodiscard]] const DecoderFaults& faults() const noexcept override { return faults_; }

 private:
  using Record = std::array<std::byte, kAedat4EventBytes>;

  /// Writes none, one or two events; how many.
  [[nodiscard]] std::size_t take(std::span<const std::byte> record, Event* out) noexcept;
  [[nodiscard]] std::optional<Event> parse(std::span<const std::byte> record) noexcept;

  int width_px_;
  int height_px_;
  Record partial_{};  ///< beginning of a record cut by the end of a chunk
  std::size_t partial_bytes_ = 0;
  EventClock clock_;
  std::optional<Event> waiting_;  ///< its stamp is not believed yet
  DecoderFaults faults_;
};

}  // namespace pled
