#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pled_vins/hal/event_source.hpp"

/// EVT3 words by name, and decoding of whole sequences, for tests.
namespace pled::support {

using Word = std::uint16_t;
using Words = std::vector<Word>;

[[nodiscard]] constexpr Word evt3(unsigned type, unsigned payload) {
  return static_cast<Word>(type << 12 | payload);
}
[[nodiscard]] constexpr Word addr_y(unsigned y) { return evt3(0x0, y); }
[[nodiscard]] constexpr Word cd(unsigned x, Polarity p) {
  return evt3(0x2, x | static_cast<unsigned>(p) << 11);
}
[[nodiscard]] constexpr Word vect_base(unsigned x, Polarity p) {
  return evt3(0x3, x | static_cast<unsigned>(p) << 11);
}
[[nodiscard]] constexpr Word vect_12(unsigned mask) { return evt3(0x4, mask); }
[[nodiscard]] constexpr Word vect_8(unsigned mask) { return evt3(0x5, mask); }
[[nodiscard]] constexpr Word time_low(unsigned us) { return evt3(0x6, us); }
[[nodiscard]] constexpr Word continued_4(unsigned bits) { return evt3(0x7, bits); }
[[nodiscard]] constexpr Word time_high(unsigned high) { return evt3(0x8, high); }
[[nodiscard]] constexpr Word trigger(unsigned id, unsigned value) {
  return evt3(0xA, id << 8 | value);
}
[[nodiscard]] constexpr Word others(unsigned subtype) { return evt3(0xE, subtype); }
[[nodiscard]] constexpr Word continued_12(unsigned bits) { return evt3(0xF, bits); }

[[nodiscard]] inline std::vector<std::byte> wire(const Words& words) {
  std::vector<std::byte> bytes;
  for (const Word word : words) {
    bytes.push_back(static_cast<std::byte>(word & 0xFF));
    bytes.push_back(static_cast<std::byte>(word >> 8));
  }
  return bytes;
}

/// Decodes all bytes, handing them over in parts of `part` and with room for
/// `room` events a call.
[[nodiscard]] inline std::vector<Event> decode_all(EventDecoder& decoder,
                                                   std::span<const std::byte> bytes,
                                                   std::size_t part = 1 << 20,
                                                   std::size_t room = EventDecoder::kMinOutput) {
  std::vector<Event> all;
  std::vector<Event> out(room);
  while (!bytes.empty()) {
    std::span<const std::byte> chunk = bytes.first(std::min(part, bytes.size()));
    bytes = bytes.subspan(chunk.size());
    while (!chunk.empty()) {
      const DecodeStep step = decoder.decode(chunk, out);
      chunk = chunk.subspan(step.bytes_consumed);
      all.insert(all.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(step.events));
      if (step.bytes_consumed == 0 && step.events == 0) return all;  // no progress: a fault
    }
  }
  return all;
}

[[nodiscard]] inline std::vector<Event> decode_all(EventDecoder& decoder, const Words& words) {
  return decode_all(decoder, wire(words));
}

[[nodiscard]] inline bool same(const Event& a, const Event& b) {
  return a.t == b.t && a.x_px == b.x_px && a.y_px == b.y_px && a.polarity == b.polarity;
}

[[nodiscard]] inline bool same(const std::vector<Event>& a, const std::vector<Event>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!same(a[i], b[i])) return false;
  }
  return true;
}

}  // namespace pled::support
