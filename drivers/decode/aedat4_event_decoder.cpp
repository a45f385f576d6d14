#include "drivers/decode/aedat4_event_decoder.hpp"

#include <algorithm>
#include <cstdlib>

#include "pled_vins/core/check.hpp"

namespace pled {

Aedat4EventDecoder::Aedat4EventDecoder(int width_px, int height_px) noexcept
    : width_px_(width_px), height_px_(height_px) {
  PLED_CHECK(width_px > 0 && height_px > 0);
}

DecodeStep Aedat4EventDecoder::decode(std::span<const std::byte> bytes,
                                      std::span<Event> out) noexcept {
  constexpr std::size_t kMostOfARecord = 2;
  PLED_CHECK(out.size() >= kMinOutput);
  std::size_t at = 0;
  std::size_t events = 0;
  while (at < bytes.size() && out.size() - events >= kMostOfARecord) {
    const std::size_t part = std::min(kAedat4EventBytes - partial_bytes_, bytes.size() - at);
    const std::span<const std::byte> next = bytes.subspan(at, part);
    at += part;
    if (part == kAedat4EventBytes) {
      events += take(next, out.data() + events);
      continue;
    }
    std::copy(next.begin(), next.end(), partial_.begin() + partial_bytes_);
    partial_bytes_ += part;
    if (partial_bytes_ < kAedat4EventBytes) break;
    partial_bytes_ = 0;
    events += take(partial_, out.data() + events);
  }
  return {at, events};
}

std::size_t Aedat4EventDecoder::take(std::span<const std::byte> record, Event* out) noexcept {
  const std::optional<Event> event = parse(record);
  if (!event) return 0;
  if (clock_.has_time() && event->t.us - clock_.last_us() <= kMaxStep_us) {
    if (waiting_) ++faults_.malformed;
    waiting_.reset();
    out[0] = clock_.held(*event, faults_);
    return 1;
  }
  if (waiting_ && std::llabs(event->t.us - waiting_->t.us) <= kMaxStep_us) {
    out[0] = clock_.held(*waiting_, faults_);
    out[1] = clock_.held(*event, faults_);
    waiting_.reset();
    return 2;
  }
  if (waiting_) ++faults_.malformed;
  waiting_ = event;
  return 0;
}

std::optional<Event> Aedat4EventDecoder::parse(std::span<const std::byte> record) noexcept {
  constexpr std::size_t kX = 8;
  constexpr std::size_t kY = 10;
  constexpr std::size_t kPolarity = 12;
  const std::int64_t t_us = *read_little_endian<std::int64_t>(record, 0);
  const int x = *read_little_endian<std::int16_t>(record, kX);
  const int y = *read_little_endian<std::int16_t>(record, kY);
  const auto polarity = std::to_integer<unsigned>(record[kPolarity]);
  if (polarity > 1 || t_us > kMaxAedat4Stamp_us || t_us < -kMaxAedat4Stamp_us) {
    ++faults_.malformed;
    return std::nullopt;
  }
  if (x < 0 || y < 0 || x >= width_px_ || y >= height_px_) {
    ++faults_.outside_sensor;
    return std::nullopt;
  }
  return Event{{t_us},
               static_cast<std::uint16_t>(x),
               static_cast<std::uint16_t>(y),
               polarity == 1 ? Polarity::kOn : Polarity::kOff};
}

void Aedat4EventDecoder::resynchronise() noexcept {
  partial_bytes_ = 0;
  ++faults_.gaps;
}

void Aedat4EventDecoder::finish() noexcept {
  if (partial_bytes_ != 0) ++faults_.malformed;
  if (waiting_) ++faults_.before_sync;
  partial_bytes_ = 0;
  waiting_.reset();
}

}  // namespace pled
