#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "pled_vins/core/image_view.hpp"
#include "pled_vins/core/timestamp.hpp"
#include "pled_vins/events/active_surface.hpp"
#include "pled_vins/events/event_warp.hpp"
#include "pled_vins/events/turn_history.hpp"

namespace pled {

enum class SurfaceTone : std::uint8_t {
  kSigned,    ///< 127.5 (1 + p e^{-age / eta}): ON bright, OFF dark, 128 without event
  kUnsigned,  ///< 255 e^{-age / eta}, eq. (1): 0 without event
};

enum class HoleFill : std::uint8_t {
  kNone,
  kBetween,  ///< an empty pixel between two opposite neighbours takes the newer of the two
};

/// Draws the active surface as an 8-bit picture at one instant: each pixel shows the age of its
/// newest accepted event, of either polarity (of two with one stamp, ON). Events after t_ref count
/// as of age 0. By table: 1024 steps over 6.24 eta, beyond which a value rounds to neutral; within
/// 1.3 grey levels of the formula. No allocation.
class TimeSurface {
 public:
  /// @param eta_ms  decay constant, within the limits of EventConfig::surface_decay_ms
  explicit TimeSurface(double eta_ms) noexcept;

  /// Age from which on a pixel is neutral: 6.24 eta. Slices over [t_ref - horizon(), t_ref] reach
  /// everything that can be seen.
  [[nodiscard]] Duration horizon() const noexcept { return {horizon_us_}; }

  /// Every event where the sensor saw it. `out` has the sensor's size; false, untouched, otherwise.
  bool render(const ActiveSurface& surface, Timestamp t_ref, SurfaceTone tone,
              ImageView<std::uint8_t> out) const noexcept;

  /// The newest accepted event of each raw pixel carried to slices.t_ref by the slice of its own
  /// stamp; where several meet, the newest wins. `out` has the size of the warp's grid, `scratch`
  /// a value for each of its pixels.
  ///
  /// Differs from carrying every event: an older event of the same raw pixel is not drawn, though
  /// the turn between the two has taken it elsewhere. Bounded by the number of pixels instead,
  /// whatever the event rate. src/events/README.md tells how much it matters.
  /// @returns false, with `out` untouched, when a size does not fit.
  bool render(const ActiveSurface& surface, const EventWarp& warp, const TurnSlices& slices,
              SurfaceTone tone, HoleFill fill, std::span<std::uint16_t> scratch,
              ImageView<std::uint8_t> out) const noexcept;

 private:
  static constexpr int kSteps = 1024;
  /// A pixel's newest event as one number: 0 none, else twice the freshness (1 ... 32767, least for
  /// the oldest) plus the polarity, so that of two events the newer has the greater key. `age_us`,
  /// below 0 after t_ref, is set when the key is not 0.
  [[nodiscard]] std::uint16_t key(const SurfacePixel& pixel, std::uint32_t t_ref_us,
                                  std::int64_t& age_us) const noexcept;
  [[nodiscard]] std::uint8_t grey(SurfaceTone tone, std::uint16_t key) const noexcept {
    if (key == 0) return tone == SurfaceTone::kSigned ? 128 : 0;
    return grey_[static_cast<std::size_t>(tone)][key & 1U][key >> 6];
  }
  void carry_all(const ActiveSurface& surface, const EventWarp& warp, const TurnSlices& slices,
                 std::span<std::uint16_t> keys) const noexcept;
  void paint(std::span<const std::uint16_t> keys, SurfaceTone tone,
             std::span<std::uint8_t> out) const noexcept;
  /// Paints the holes of a row of keys that has rows above and below.
  void fill_row(const std::uint16_t* keys, std::size_t width, SurfaceTone tone,
                std::span<std::uint8_t> out) const noexcept;

  std::int64_t horizon_us_ = 0;
  std::uint64_t freshness_per_us_q32_ = 0;
  /// Grey value by tone, polarity and freshness / 32.
  std::array<std::array<std::array<std::uint8_t, kSteps>, 2>, 2> grey_{};
};

}  // namespace pled
