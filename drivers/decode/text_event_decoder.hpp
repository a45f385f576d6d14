#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "drivers/decode/event_clock.hpp"
#include "pled_vins/hal/event_source.hpp"

namespace pled {

/// Text lines `t x y p` to events: t in seconds, to the nearest microsecond
/// without passing through a double; p is 0 or 1, or -1 or 1. Blank lines and
/// lines beginning with '#' are skipped; any other line that does not read so is
/// counted in `malformed`. Lines end with \n or \r\n; the last line needs its
/// end as well (RawFileSource supplies a missing one).
///
/// Stamps that go back are EventClock's to judge. Ours: one more than kMaxStep_us
/// ahead of the last waits for the next event and is malformed when that does not go on from it,
/// so that one damaged line cannot hold all that follow. At the end of the stream it counts in
/// `before_sync`.
class TextEventDecoder final : public EventDecoder {
 public:
  static constexpr std::int64_t kMaxStep_us = 131'072;
  /// Longer lines are malformed.
  static constexpr std::size_t kMaxLine = 256;

  /// Events with x in [0, width_px) and y in [0, height_px) pass.
  TextEventDecoder(int width_px, int height_px) noexcept;

  DecodeStep decode(std::span<const std::byte> bytes, std::span<Event> out) noexcept override;
  void resynchronise() noexcept override;
  void finish() noexcept override;
  [[nodiscard]] const DecoderFaults& faults() const noexcept override { return faults_; }

 private:
  [[nodiscard]] std::optional<Event> parse(std::string_view line) noexcept;
  [[nodiscard]] std::size_t take(const Event& event, Event* out) noexcept;
  void keep(std::string_view part) noexcept;

  std::uint32_t width_px_;
  std::uint32_t height_px_;
  std::array<char, kMaxLine> partial_{};  ///< beginning of a line cut by the end of a chunk
  std::size_t partial_size_ = 0;
  bool too_long_ = false;     ///< the line that began outgrew `partial_`
  bool skip_to_end_ = false;  ///< bytes were lost: the rest of this line is no whole line
  EventClock clock_;
  std::optional<Event> waiting_;  ///< its stamp leapt ahead of the last
  DecoderFaults faults_;
};

}  // namespace pled
