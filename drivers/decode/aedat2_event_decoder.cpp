#include "drivers/decode/aedat2_event_decoder.hpp"

#include <algorithm>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

constexpr int kMaxWidth = 1024;  // the bits of an address
constexpr int kMaxHeight = 512;

}  // namespace

Aedat2EventDecoder::Aedat2EventDecoder(int width_px, int height_px) noexcept
    : width_px_(static_cast<std::uint32_t>(std::min(width_px, kMaxWidth))),
      height_px_(static_cast<std::uint32_t>(std::min(height_px, kMaxHeight))) {
  PLED_CHECK(width_px > 0 && height_px > 0);
}

DecodeStep Aedat2EventDecoder::decode(std::span<const std::byte> bytes,
                                      std::span<Event> out) noexcept {
  PLED_CHECK(out.size() >= kMinOutput);
  std::span<const std::byte> rest = bytes;
  std::size_t events = 0;
  // Two records may come out of the last bytes: neither may be left for a call that has none.
  while ((!rest.empty() && out.size() - events >= 2) || records_.has_next()) {
    const auto record = records_.next(rest);
    if (record && take(*record, out[events])) ++events;
  }
  collect_faults();
  return {bytes.size() - rest.size(), events};
}

bool Aedat2EventDecoder::take(const Aedat2Record& record, Event& out) noexcept {
  const Aedat2Kind kind = record.kind();
  if (kind == Aedat2Kind::kUnknown) ++unknown_;
  if (kind != Aedat2Kind::kEvent) return false;
  if (record.x() >= width_px_ || record.y() >= height_px_) {
    ++faults_.outside_sensor;
    return false;
  }
  if (has_time_ && record.t_us < last_us_) ++faults_.time_backwards;
  last_us_ = has_time_ ? std::max(last_us_, record.t_us) : record.t_us;
  has_time_ = true;
  out = {{last_us_},
         static_cast<std::uint16_t>(width_px_ - 1 - record.x()),
         static_cast<std::uint16_t>(height_px_ - 1 - record.y()),
         record.on() ? Polarity::kOn : Polarity::kOff};
  return true;
}

void Aedat2EventDecoder::collect_faults() noexcept {
  faults_.malformed = unknown_ + records_.faults().malformed;
  faults_.gaps = losses_ + records_.faults().restarts;
  faults_.before_sync = records_.faults().unconfirmed;
}

void Aedat2EventDecoder::resynchronise() noexcept {
  records_.resynchronise();
  ++losses_;
  collect_faults();
}

void Aedat2EventDecoder::finish() noexcept {
  records_.finish();
  collect_faults();
}

}  // namespace pled
