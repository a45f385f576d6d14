#include "drivers/decode/evt3_decoder.hpp"

#include <algorithm>
#include <bit>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

// Word types, bits 15..12.
enum Type : std::uint32_t {
  kAddrY = 0x0,
  kExposureY = 0x1,  // row of an old exposure measurement: what follows is no brightness change
  kAddrX = 0x2,
  kVectBaseX = 0x3,
  kVect12 = 0x4,
  kVect8 = 0x5,
  kTimeLow = 0x6,
  kContinued4 = 0x7,
  kTimeHigh = 0x8,
  kExtTrigger = 0xA,
  kOthers = 0xE,
  kContinued12 = 0xF,
};

constexpr std::uint32_t kPayload = 0xFFF;
constexpr std::uint32_t kAddress = 0x7FF;
constexpr std::uint32_t kMaxSide = 2048;
constexpr std::ptrdiff_t kMaxEventsPerWord = 12;

constexpr int kHighCount = 4096;                        // values of TIME_HIGH
constexpr std::int64_t kHighUs = 4096;                  // one step of TIME_HIGH
constexpr std::int64_t kLoopUs = kHighCount * kHighUs;  // 16.777216 s

[[nodiscard]] constexpr Polarity polarity_of(std::uint32_t word) noexcept {
  return static_cast<Polarity>((word >> 11) & 1U);
}

/// Steps from one TIME_HIGH forward to another, modulo the wrap.
[[nodiscard]] constexpr int steps_forward(int from, int to) noexcept {
  return (to - from) & (kHighCount - 1);
}

}  // namespace

Evt3Decoder::Evt3Decoder(int width_px, int height_px) noexcept
    : width_px_(static_cast<std::uint32_t>(width_px)),
      height_px_(static_cast<std::uint32_t>(height_px)) {
  PLED_CHECK(width_px > 0 && width_px_ <= kMaxSide);
  PLED_CHECK(height_px > 0 && height_px_ <= kMaxSide);
}

DecodeStep Evt3Decoder::decode(std::span<const std::byte> bytes, std::span<Event> out) noexcept {
  PLED_CHECK(out.size() >= kMinOutput);
  const std::byte* in = bytes.data();
  const std::byte* const end = in + bytes.size();
  Event* write = out.data();
  const Event* const last_start = out.data() + out.size() - kMaxEventsPerWord;
  Cursor cursor = cursor_;

  if (has_half_word_ && in != end) {
    const auto word = half_word_ | std::to_integer<std::uint32_t>(in[0]) << 8;
    has_half_word_ = false;
    ++in;
    write = take(word, cursor, write);
  }
  while (end - in >= 2 && write <= last_start) {
    const auto word = std::to_integer<std::uint32_t>(in[0]) | std::to_integer<std::uint32_t>(in[1])
                                                                  << 8;
    in += 2;
    write = take(word, cursor, write);
  }
  if (end - in == 1) {
    half_word_ = std::to_integer<std::uint8_t>(*in);
    has_half_word_ = true;
    ++in;
  }
  cursor_ = cursor;
  return {static_cast<std::size_t>(in - bytes.data()),
          static_cast<std::size_t>(write - out.data())};
}

[[gnu::always_inline]] inline Event* Evt3Decoder::take(std::uint32_t word, Cursor& cursor,
                                                       Event* out) noexcept {
  switch (word >> 12) {
    case kAddrY:
      cursor.y = word & kAddress;
      row_ = Row::kSeen;
      cursor.usable = usable(cursor.y);
      return out;
    case kAddrX: {
      const std::uint32_t x = word & kAddress;
      if (!cursor.usable || x >= width_px_) {
        count_unusable(1, cursor.y, true);
        return out;
      }
      *out = {{cursor.now_us},
              static_cast<std::uint16_t>(x),
              static_cast<std::uint16_t>(cursor.y),
              polarity_of(word)};
      return out + 1;
    }
    case kVectBaseX:
      cursor.base_x = word & kAddress;
      cursor.vector_polarity = polarity_of(word);
      base_known_ = true;
      return out;
    case kVect12: return take_vector(word & kPayload, 12, cursor, out);
    case kVect8: return take_vector(word & 0xFF, 8, cursor, out);
    case kTimeLow: {
      if (!time_known()) return out;
      const std::int64_t t_us = high_us_ + (word & kPayload);
      if (t_us >= cursor.now_us) {
        cursor.now_us = t_us;
      } else {
        ++faults_.time_backwards;
      }
      return out;
    }
    case kTimeHigh:
      take_time_high(static_cast<int>(word & kPayload));
      cursor.now_us = std::max(cursor.now_us, high_us_);
      cursor.usable = usable(cursor.y);
      return out;
    default:
      take_rare(word >> 12);
      cursor.usable = usable(cursor.y);
      return out;
  }
}

[[gnu::always_inline]] inline Event* Evt3Decoder::take_vector(std::uint32_t mask,
                                                              std::uint32_t bits, Cursor& cursor,
                                                              Event* out) noexcept {
  const std::uint32_t base = cursor.base_x;
  // No row is longer than the address space; the stop keeps endless vectors from wrapping.
  cursor.base_x = std::min(base + bits, kMaxSide);
  if (!cursor.usable || !base_known_) {
    count_unusable(static_cast<std::uint32_t>(std::popcount(mask)), cursor.y, base_known_);
    return out;
  }
  if (base + bits > width_px_) mask = cut_at_edge(mask, base);
  for (; mask != 0; mask &= mask - 1) {
    const std::uint32_t x = base + static_cast<std::uint32_t>(std::countr_zero(mask));
    *out++ = {{cursor.now_us},
              static_cast<std::uint16_t>(x),
              static_cast<std::uint16_t>(cursor.y),
              cursor.vector_polarity};
  }
  return out;
}

/// The events of a vector that are on the sensor; the others are counted.
std::uint32_t Evt3Decoder::cut_at_edge(std::uint32_t mask, std::uint32_t base_x) noexcept {
  const std::uint32_t room = width_px_ > base_x ? width_px_ - base_x : 0;
  const std::uint32_t inside = mask & ((1U << room) - 1U);  // room < 12
  faults_.outside_sensor += static_cast<std::uint64_t>(std::popcount(mask ^ inside));
  return inside;
}

void Evt3Decoder::take_rare(std::uint32_t type) noexcept {
  switch (type) {
    case kExtTrigger: ++triggers_; return;
    case kOthers:
      continuations_left_ = 3;  // 12 + 12 + 4 bits, low part first
      return;
    case kContinued12:
    case kContinued4:
      if (continuations_left_ > 0) {
        --continuations_left_;
      } else {
        ++faults_.malformed;
      }
      return;
    case kExposureY:
      row_ = Row::kForeign;
      ++faults_.malformed;
      return;
    default:  // reserved
      ++faults_.malformed;
      return;
  }
}

void Evt3Decoder::take_time_high(int high) noexcept {
  if (high_ < 0) {
    high_ = high;
    high_us_ = high * kHighUs;
    after_gap_ = false;
    return;
  }
  const int forward = steps_forward(high_, high);
  if (forward <= kMaxHighStep) {
    after_gap_ = false;
    suspect_high_ = -1;
    if (forward != 0) move_high(high, high < high_);
    return;
  }
  if (kHighCount - forward <= kMaxHighStep) {  // late
    ++faults_.time_backwards;
    return;
  }
  // A wrap is believed only from near the end to near the beginning.
  const bool wrapped = high_ - high > kHighCount / 2;
  const bool confirmed = suspect_high_ >= 0 && steps_forward(suspect_high_, high) <= kMaxHighStep;
  if (confirmed || (after_gap_ && (wrapped || high > high_))) {
    if (!after_gap_) ++faults_.gaps;
    after_gap_ = false;
    suspect_high_ = -1;
    move_high(high, wrapped);
    return;
  }
  suspect_high_ = high;
  ++faults_.malformed;
}

/// A new TIME_HIGH starts at TIME_LOW 0; the sensor sends the TIME_LOW that follows.
void Evt3Decoder::move_high(int high, bool next_loop) noexcept {
  const std::int64_t loop_us = high_us_ - high_ * kHighUs;
  high_ = high;
  high_us_ = loop_us + (next_loop ? kLoopUs : 0) + high * kHighUs;
}

/// An event word that cannot be used: why, by what is known at this moment.
void Evt3Decoder::count_unusable(std::uint32_t events, std::uint32_t y,
                                 bool position_known) noexcept {
  if (row_ == Row::kForeign) {
    ++faults_.malformed;
  } else if (!time_known() || row_ == Row::kUnknown || (y < height_px_ && !position_known)) {
    ++faults_.before_sync;
  } else {
    faults_.outside_sensor += events;
  }
}

void Evt3Decoder::resynchronise() noexcept {
  has_half_word_ = false;
  row_ = Row::kUnknown;
  base_known_ = false;
  cursor_.usable = false;
  continuations_left_ = 0;
  suspect_high_ = -1;
  after_gap_ = true;
  ++faults_.gaps;
}

void Evt3Decoder::finish() noexcept {
  if (has_half_word_) ++faults_.malformed;
  has_half_word_ = false;
}

}  // namespace pled
