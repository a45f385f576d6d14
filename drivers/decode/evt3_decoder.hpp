#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "pled_vins/hal/event_source.hpp"

namespace pled {

/// Prophesee EVT 3.0, little-endian 16-bit words, to events. The same decoder
/// serves recordings and devices.
///
/// Time: the wire has 24 bits of microseconds, TIME_HIGH (bits 23..12) and
/// TIME_LOW (11..0); the decoder unwraps them to 64 bits, beginning with the
/// first TIME_HIGH. Ours: a TIME_HIGH at most kMaxHighStep ahead (modulo the
/// wrap) is taken at once, one as little behind is late and only counted; any
/// other is taken when the next TIME_HIGH agrees with it, so that one flipped
/// bit cannot throw the clock. TIME_LOW never carries into TIME_HIGH: sensors
/// step it back by some microseconds now and then. The time given out is held
/// where the sensor's goes back.
///
/// Events before the first TIME_HIGH and ADDR_Y are dropped and counted in
/// `before_sync` (words); events off the sensor in `outside_sensor` (events).
class Evt3Decoder final : public EventDecoder {
 public:
  /// 31 * 4.096 ms = 127 ms: longer than a sensor stays silent, and short enough
  /// that one flipped bit that is believed holds the time for 66 ms at most.
  static constexpr int kMaxHighStep = 31;

  /// Events with x in [0, width_px) and y in [0, height_px) pass; both in 1..2048.
  Evt3Decoder(int width_px, int height_px) noexcept;

  DecodeStep decode(std::span<const std::byte> bytes, std::span<Event> out) noexcept override;
  void resynchronise() noexcept override;
  void finish() noexcept override;
  [[nodiscard]] const DecoderFaults& faults() const noexcept override { return faults_; }
  /// External trigger words met so far.
  [[nodiscard]] std::uint64_t triggers() const noexcept { return triggers_; }

 private:
  /// What the last row address says about the events that follow it.
  enum class Row : std::uint8_t { kUnknown, kSeen, kForeign };

  /// The part of the state that every word reads. decode() works on a copy whose
  /// address goes nowhere, so that it lives in registers.
  struct Cursor {
    std::int64_t now_us = 0;   ///< time given out; never decreases
    std::uint32_t base_x = 0;  ///< pixel of bit 0 of the next vector
    std::uint32_t y = 0;
    Polarity vector_polarity = Polarity::kOff;
    bool usable = false;  ///< time and row are known and the row is on the sensor
  };

  Event* take(std::uint32_t word, Cursor& cursor, Event* out) noexcept;
  Event* take_vector(std::uint32_t mask, std::uint32_t bits, Cursor& cursor, Event* out) noexcept;
  std::uint32_t cut_at_edge(std::uint32_t mask, std::uint32_t base_x) noexcept;
  void take_rare(std::uint32_t type) noexcept;
  void take_time_high(int high) noexcept;
  void move_high(int high, bool next_loop) noexcept;
  void count_unusable(std::uint32_t events, std::uint32_t y, bool position_known) noexcept;
  [[nodiscard]] bool time_known() const noexcept { return high_ >= 0 && !after_gap_; }
  [[nodiscard]] bool usable(std::uint32_t y) const noexcept {
    return row_ == Row::kSeen && time_known() && y < height_px_;
  }

  std::uint32_t width_px_;
  std::uint32_t height_px_;
  Cursor cursor_;
  std::int64_t high_us_ = 0;    ///< unwrapped time of the current TIME_HIGH
  int high_ = -1;               ///< the current TIME_HIGH, 12 bits; -1 before the first
  int suspect_high_ = -1;       ///< a TIME_HIGH that waits for the next to agree
  int continuations_left_ = 0;  ///< words that may still follow an OTHERS
  Row row_ = Row::kUnknown;
  bool base_known_ = false;
  bool after_gap_ = false;  ///< no TIME_HIGH yet since bytes were lost
  bool has_half_word_ = false;
  std::uint8_t half_word_ = 0;  ///< first byte of a word cut by the end of a chunk
  std::uint64_t triggers_ = 0;
  DecoderFaults faults_;
};

}  // namespace pled
