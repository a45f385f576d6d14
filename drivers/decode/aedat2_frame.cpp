#include "drivers/decode/aedat2_frame.hpp"

#include <algorithm>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

constexpr std::uint16_t kNotRead = 0xFFFF;  // samples have 10 bits

}  // namespace

Aedat2FrameCollector::Aedat2FrameCollector(int width_px, int height_px,
                                           std::span<std::uint16_t> samples) noexcept
    : width_px_(static_cast<std::uint32_t>(width_px)),
      height_px_(static_cast<std::uint32_t>(height_px)) {
  const std::size_t pixels = std::size_t{width_px_} * height_px_;
  PLED_CHECK(width_px > 0 && height_px > 0 && samples.size() == 2 * pixels);
  reset_ = samples.first(pixels);
  signal_ = samples.subspan(pixels);
  begin();
}

void Aedat2FrameCollector::begin() noexcept {
  std::fill(reset_.begin(), reset_.end(), kNotRead);
  std::fill(signal_.begin(), signal_.end(), kNotRead);
  resets_ = {};
  signals_ = {};
}

void Aedat2FrameCollector::Reads::add(std::int64_t t_us) noexcept {
  first_us = count == 0 ? t_us : std::min(first_us, t_us);
  last_us = count == 0 ? t_us : std::max(last_us, t_us);
  ++count;
}

bool Aedat2FrameCollector::take(const Aedat2Record& record) noexcept {
  const Aedat2Kind kind = record.kind();
  if (kind != Aedat2Kind::kReset && kind != Aedat2Kind::kSignal) return false;
  if (record.x() >= width_px_ || record.y() >= height_px_) {
    ++outside_;
    return false;
  }
  const std::size_t pixel = std::size_t{height_px_ - 1 - record.y()} * width_px_ + record.x();
  const auto sample = static_cast<std::uint16_t>(record.sample());
  if (kind == Aedat2Kind::kReset) {
    if (reset_[pixel] != kNotRead) {
      if (signals_.count < signal_.size()) ++incomplete_;
      begin();
    }
    reset_[pixel] = sample;
    resets_.add(record.t_us);
    return false;
  }
  // Of a frame that began before the file did, or a second signal: neither can be paired.
  if (reset_[pixel] == kNotRead || signal_[pixel] != kNotRead) return false;
  signal_[pixel] = sample;
  signals_.add(record.t_us);
  return signals_.count == signal_.size();
}

void Aedat2FrameCollector::render(std::span<std::uint8_t> out) const noexcept {
  PLED_CHECK(out.size() >= reset_.size());
  for (std::size_t i = 0; i < reset_.size(); ++i)
    out[i] = static_cast<std::uint8_t>(std::max(0, reset_[i] - signal_[i]) / 4);
}

std::int64_t Aedat2FrameCollector::t_us() const noexcept {
  const bool rolling = signals_.first_us < resets_.last_us;
  if (!rolling) return resets_.last_us + (signals_.first_us - resets_.last_us) / 2;
  const std::int64_t begin_us = resets_.first_us;
  return begin_us + ((resets_.last_us - begin_us) + (signals_.first_us - begin_us) +
                     (signals_.last_us - begin_us)) /
                        4;
}

}  // namespace pled
