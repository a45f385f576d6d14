#include "pled_vins/events/brightness_surface.hpp"

#include <algorithm>
#include <cmath>

#include "pled_vins/core/check.hpp"

namespace pled {

BrightnessSurface::BrightnessSurface(double tau_ms, int width_px, int height_px,
                                     std::span<BrightnessPixel> pixels) noexcept
    : width_px_(width_px),
      height_px_(height_px),
      pixels_(pixels),
      steps_per_us_(static_cast<float>(kSteps / (static_cast<double>(kReach) * tau_ms * 1e3))) {
  PLED_CHECK(tau_ms > 0.0 && width_px > 0 && height_px > 0);
  PLED_CHECK(pixels.size() >=
             static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px));
  // In the middle of its step, except that no time at all is no decay.
  decay_[0] = 1.0F;
  for (int k = 1; k < kSteps; ++k)
    decay_[static_cast<std::size_t>(k)] =
        std::exp(-kReach * (static_cast<float>(k) + 0.5F) / static_cast<float>(kSteps));
  clear();
}

void BrightnessSurface::clear() noexcept {
  std::fill(pixels_.begin(), pixels_.end(), BrightnessPixel{});
}

/// Stamps that go back by a little count as simultaneous.
float BrightnessSurface::decay(std::int32_t dt_us) const noexcept {
  const float step = static_cast<float>(std::max(dt_us, 0)) * steps_per_us_;
  return decay_[static_cast<std::size_t>(std::min(step, static_cast<float>(kSteps)))];
}

void BrightnessSurface::insert(std::span<const Event> events,
                               std::span<const EventVerdict> verdicts) noexcept {
  PLED_CHECK(verdicts.size() >= events.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (verdicts[i] == EventVerdict::kHot || verdicts[i] == EventVerdict::kDropped) continue;
    const Event& e = events[i];
    BrightnessPixel& pixel =
        pixels_[static_cast<std::size_t>(e.y_px) * static_cast<std::size_t>(width_px_) + e.x_px];
    const auto t_us = static_cast<std::uint32_t>(e.t.us);
    const bool on = e.polarity == Polarity::kOn;
    const float kept = decay(static_cast<std::int32_t>(t_us - pixel.stamp_us()));
    pixel.level = std::clamp(pixel.level * kept + (on ? 1.0F : -1.0F), -kMaxLevel, kMaxLevel);
    pixel.last = (t_us & ~1U) | (on ? 1U : 0U);
  }
}

bool BrightnessSurface::render(Timestamp t_ref, ImageView<std::uint8_t> out) noexcept {
  if (out.width != width_px_ || out.height != height_px_) return false;
  const auto now_us = static_cast<std::uint32_t>(t_ref.us);
  for (int y = 0; y < height_px_; ++y) {
    BrightnessPixel* row =
        pixels_.data() + static_cast<std::ptrdiff_t>(y) * static_cast<std::ptrdiff_t>(width_px_);
    std::uint8_t* grey = out.row(y);
    for (int x = 0; x < width_px_; ++x) {
      BrightnessPixel& pixel = row[x];
      const float kept = decay(static_cast<std::int32_t>(now_us - pixel.stamp_us()));
      // So that its stamp may wrap round without the level coming back.
      if (kept == 0.0F) pixel.level = 0.0F;
      float pending = kept * kept * kept;
      pending = pixel.level == 0.0F ? 0.0F : (pixel.last & 1U) != 0 ? pending : -pending;
      const float value = 128.5F + kGreyPerStep * (pixel.level * kept + pending);
      grey[x] = static_cast<std::uint8_t>(std::clamp(value, 0.0F, 255.0F));
    }
  }
  return true;
}

}  // namespace pled
