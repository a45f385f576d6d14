#include "drivers/decode/text_event_decoder.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "drivers/decode/decimal.hpp"
#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

/// Whether a stamp is too far ahead of another; stamps have any value, so no difference is taken.
bool leaps(std::int64_t t_us, std::int64_t from_us) noexcept {
  return from_us < std::numeric_limits<std::int64_t>::max() - TextEventDecoder::kMaxStep_us &&
         t_us > from_us + TextEventDecoder::kMaxStep_us;
}

}  // namespace

TextEventDecoder::TextEventDecoder(int width_px, int height_px) noexcept
    : width_px_(static_cast<std::uint32_t>(width_px)),
      height_px_(static_cast<std::uint32_t>(height_px)) {
  PLED_CHECK(width_px > 0 && height_px > 0);
}

DecodeStep TextEventDecoder::decode(std::span<const std::byte> bytes,
                                    std::span<Event> out) noexcept {
  PLED_CHECK(out.size() >= kMinOutput);
  const char* const text = reinterpret_cast<const char*>(bytes.data());
  constexpr std::size_t kMostOfALine = 2;
  std::size_t at = 0;
  std::size_t events = 0;
  while (at < bytes.size() && out.size() - events >= kMostOfALine) {
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
    if (!whole) continue;
    if (const std::optional<Event> event = parse(line)) events += take(*event, &out[events]);
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

std::optional<Event> TextEventDecoder::parse(std::string_view line) noexcept {
  line = trimmed_line(line);
  if (is_blank_or_comment(line)) return std::nullopt;
  if (line.size() > kMaxLine) {
    ++faults_.malformed;
    return std::nullopt;
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
    return std::nullopt;
  }
  if (*x < 0 || *y < 0 || static_cast<std::uint32_t>(*x) >= width_px_ ||
      static_cast<std::uint32_t>(*y) >= height_px_) {
    ++faults_.outside_sensor;
    return std::nullopt;
  }
  return Event{{*t_us},
               static_cast<std::uint16_t>(*x),
               static_cast<std::uint16_t>(*y),
               on ? Polarity::kOn : Polarity::kOff};
}

std::size_t TextEventDecoder::take(const Event& event, Event* out) noexcept {
  std::size_t events = 0;
  if (waiting_) {
    if (leaps(waiting_->t.us, event.t.us))
      ++faults_.malformed;
    else
      out[events++] = clock_.held(*waiting_, faults_);
    waiting_.reset();
  }
  if (clock_.has_time() && leaps(event.t.us, clock_.last_us()))
    waiting_ = event;
  else
    out[events++] = clock_.held(event, faults_);
  return events;
}

void TextEventDecoder::resynchronise() noexcept {
  partial_size_ = 0;
  too_long_ = false;
  skip_to_end_ = true;
  ++faults_.gaps;
}

void TextEventDecoder::finish() noexcept {
  if ((partial_size_ != 0 || too_long_) && !skip_to_end_) ++faults_.malformed;
  if (waiting_) ++faults_.before_sync;
  waiting_.reset();
  partial_size_ = 0;
  too_long_ = false;
  skip_to_end_ = false;
}

}  // namespace pled
