#include "drivers/decode/text_event_decoder.hpp"

#include <algorithm>
#include <cstring>

#include "drivers/decode/decimal.hpp"
#include "pled_vins/core/check.hpp"

namespace pled {

TextEventDecoder::TextEventDecoder(int width_px, int height_px) noexcept
    : width_px_(static_cast<std::uint32_t>(width_px)),
      height_px_(static_cast<std::uint32_t>(height_px)) {
  PLED_CHECK(width_px > 0 && height_px > 0);
}

DecodeStep TextEventDecoder::decode(std::span<const std::byte> bytes,
                                    std::span<Event> out) noexcept {
  PLED_CHECK(out.size() >= kMinOutput);
  const char* const text = reinterpret_cast<const char*>(bytes.data());
  std::size_t at = 0;
  std::size_t events = 0;
  while (at < bytes.size() && events < out.size()) {
    const void* const found = std::memchr(text + at, '\n', bytes.size() - at);
    if (found == nullptr) {
      keep({text + at, bytes.size() - at});
      at = bytes.size();
      break;
    }
    const auto end = static_cast<std::size_t>(static_cast<const char*>(found) - text);
    std::string_view line{text + at, end - at};
    at = end + 1;
    if (partial_size_ != 0 || too_long_) {
      keep(line);
      line = {partial_.data(), partial_size_};
    }
    const bool whole = !too_long_ && !skip_to_end_;
    if (too_long_ && !skip_to_end_) ++faults_.malformed;
    partial_size_ = 0;
    too_long_ = false;
    skip_to_end_ = false;
    if (whole && take_line(line, out[events])) ++events;
  }
  return {at, events};
}

void TextEventDecoder::keep(std::string_view part) noexcept {
  if (part.size() > partial_.size() - partial_size_) {
    too_long_ = true;
    return;
  }
  std::copy(part.begin(), part.end(), partial_.data() + partial_size_);
  partial_size_ += part.size();
}

bool TextEventDecoder::take_line(std::string_view line, Event& out) noexcept {
  line = trimmed_line(line);
  if (is_blank_or_comment(line)) return false;
  if (line.size() > kMaxLine) {
    ++faults_.malformed;
    return false;
  }
  constexpr int kMicro = 6;
  const auto t_us = parse_scaled(next_field(line), kMicro);
  const auto x = parse_int(next_field(line));
  const auto y = parse_int(next_field(line));
  const std::string_view p = next_field(line);
  const bool on = p == "1" || p == "+1";
  const bool off = p == "0" || p == "-1";
  if (!t_us || !x || !y || !(on || off) || !next_field(line).empty()) {
    ++faults_.malformed;
    return false;
  }
  if (*x < 0 || *y < 0 || static_cast<std::uint32_t>(*x) >= width_px_ ||
      static_cast<std::uint32_t>(*y) >= height_px_) {
    ++faults_.outside_sensor;
    return false;
  }
  if (has_time_ && *t_us < last_us_) ++faults_.time_backwards;
  last_us_ = has_time_ ? std::max(last_us_, *t_us) : *t_us;
  has_time_ = true;
  out = {{last_us_},
         static_cast<std::uint16_t>(*x),
         static_cast<std::uint16_t>(*y),
         on ? Polarity::kOn : Polarity::kOff};
  return true;
}

void TextEventDecoder::resynchronise() noexcept {
  partial_size_ = 0;
  too_long_ = false;
  skip_to_end_ = true;
  ++faults_.gaps;
}

void TextEventDecoder::finish() noexcept {
  if ((partial_size_ != 0 || too_long_) && !skip_to_end_) ++faults_.malformed;
  partial_size_ = 0;
  too_long_ = false;
  skip_to_end_ = false;
}

}  // namespace pled
