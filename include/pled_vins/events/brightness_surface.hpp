#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "pled_vins/core/image_view.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/events/active_surface.hpp"

namespace pled {

/// How one pixel's brightness differs from what it was of late, in contrast thresholds.
struct BrightnessPixel {
  float level;         ///< at the pixel's last event
  std::uint32_t last;  ///< low 32 bits of its stamp in us; bit 0: it was an ON event

  [[nodiscard]] std::uint32_t stamp_us() const noexcept { return last & ~1U; }
};
static_assert(sizeof(BrightnessPixel) == 8);

/// The picture that events add up to: each is one contrast step of the logarithm of brightness, up
/// or down, and what happened longer ago than tau is forgotten: L <- L e^{-dt/tau} + p. Ours, after
/// Scheerlinck et al. (ACCV 2018), whose complementary filter without frames this is.
///
/// A pixel tells of a step only once it is complete. Until then the picture counts the next one as
/// on its way, in the direction of the last and fading three times as fast as the rest: p e^{-3
/// dt/tau}. Without it edges lag by up to a threshold, and tracks lag with them.
///
/// A time surface shows when edges passed, so it changes with the direction and speed of motion;
/// this shows what is there, so a patch of it looks the same for as long as it is seen. On the
/// simulated development set tracks last 2 to 6 times as long (src/events/README.md).
///
/// No allocation, no thread; how events are split into packets makes no difference.
class BrightnessSurface {
 public:
  /// @param tau_ms  within the limits of EventConfig::brightness_decay_ms
  /// @param pixels  width * height of them, outlives the object; cleared
  BrightnessSurface(double tau_ms, int width_px, int height_px,
                    std::span<BrightnessPixel> pixels) noexcept;

  /// Takes events in time order, those whose verdict is accepted or redundant: what the active
  /// surface drops, or knows to come from a hot pixel, would stay as a dot.
  void insert(std::span<const Event> events, std::span<const EventVerdict> verdicts) noexcept;
  void clear() noexcept;

  /// Grey 128 + kGreyPerStep * (L + p e^{-3 dt/tau}) at t_ref, cut off at 0 and 255. `out` has the
  /// sensor's size; false, untouched, otherwise. To be called at least every half hour, before
  /// stamps wrap.
  bool render(Timestamp t_ref, ImageView<std::uint8_t> out) noexcept;

  /// Seven steps of 20 % contrast up or down can be told apart.
  static constexpr float kGreyPerStep = 18.0F;

 private:
  static constexpr int kSteps = 1024;
  static constexpr float kReach = 8.0F;  ///< times tau; e^-8 of any level is nothing
  static constexpr float kMaxLevel = 64.0F;

  [[nodiscard]] float decay(std::int32_t dt_us) const noexcept;

  int width_px_;
  int height_px_;
  std::span<BrightnessPixel> pixels_;
  float steps_per_us_;
  std::array<float, kSteps + 1> decay_{};  ///< e^{-dt/tau} over kReach tau; the last is 0
};

}  // namespace pled
