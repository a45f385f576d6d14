#pragma once

#include <array>
#include <cstddef>
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

/// What a pixel shows where carried events, which fall between pixels, meet.
enum class Meeting : std::uint8_t {
  kNewest,  ///< each event goes to the nearest pixel, where the newest stays; of two, ON
  /// Ours: each event is shared out bilinearly, and a pixel shows the mean of e = e^{-age / eta}
  /// with weights w e, times min(1, sum of w); events older than 4 eta are left out. Smooth where
  /// rounding leaves holes and steps: the one to track on.
  kBlended,
};

/// Draws the active surface as an 8-bit picture at one instant: ages of the newest accepted events.
/// Events after t_ref count as of age 0. By table: 1024 steps over 6.24 eta, beyond which a value
/// rounds to neutral; within 1.3 grey levels of the formula. No allocation.
class TimeSurface {
 public:
  /// @param eta_ms  decay constant, within the limits of EventConfig::surface_decay_ms
  explicit TimeSurface(double eta_ms) noexcept;

  /// Age from which on an event is not drawn: 6.24 eta, blended 4 eta. Slices over
  /// [t_ref - reach(), t_ref] reach everything that can be seen.
  [[nodiscard]] Duration reach(Meeting meeting) const noexcept {
    return {meeting == Meeting::kNewest ? horizon_us_ : blended_us_};
  }

  /// Floats of scratch that drawing carried events into a grid needs.
  [[nodiscard]] static constexpr std::size_t floats_needed(int width_px, int height_px) noexcept {
    return 4 * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  }

  /// Every event where the sensor saw it; a pixel shows the newer of its polarities, of two with
  /// one stamp ON. `out` has the sensor's size; false, untouched, otherwise.
  bool render(const ActiveSurface& surface, Timestamp t_ref, SurfaceTone tone,
              ImageView<std::uint8_t> out) const noexcept;

  /// Each raw pixel's newest accepted event of either polarity carried to slices.t_ref by the slice
  /// of its own stamp; events without slice are left out. `out` has the size of the warp's grid.
  ///
  /// Differs from carrying every event: older ones of the same raw pixel and polarity are not
  /// drawn, though the turn between the two has taken them elsewhere. Bounded by the number of
  /// pixels instead, whatever the event rate. src/events/README.md tells how much it matters.
  /// @returns false, with `out` untouched, when a size does not fit.
  bool render(const ActiveSurface& surface, const EventWarp& warp, const TurnSlices& slices,
              SurfaceTone tone, Meeting meeting, std::span<float> scratch,
              ImageView<std::uint8_t> out) const noexcept;

 private:
  static constexpr std::size_t kSteps = 1024;

  /// Age of a pixel's newest accepted event of a polarity, 0 after t_ref, horizon_us_ when it is
  /// older or there is none.
  [[nodiscard]] std::int32_t age_us(const SurfacePixel& pixel, std::size_t polarity,
                                    std::uint32_t t_ref_us) const noexcept;
  /// The table's step for an age below horizon_us_.
  [[nodiscard]] std::size_t step(std::int32_t age_us) const noexcept {
    return static_cast<std::size_t>(static_cast<std::uint64_t>(age_us) * steps_per_us_q32_ >> 32);
  }
  /// Calls place(x, y, age_us, polarity) for each event below an age that falls into the grid.
  template <typename Place>
  void carry_all(const ActiveSurface& surface, const EventWarp& warp, const TurnSlices& slices,
                 std::int32_t reach_us, const Place& place) const noexcept;
  void draw_newest(const ActiveSurface& surface, const EventWarp& warp, const TurnSlices& slices,
                   SurfaceTone tone, std::span<float> left_us,
                   ImageView<std::uint8_t> out) const noexcept;
  void draw_blended(const ActiveSurface& surface, const EventWarp& warp, const TurnSlices& slices,
                    SurfaceTone tone, std::span<float> sums,
                    ImageView<std::uint8_t> out) const noexcept;

  std::int32_t horizon_us_ = 0;
  std::int32_t blended_us_ = 0;
  std::uint64_t steps_per_us_q32_ = 0;
  std::array<float, kSteps> decay_{};  ///< e^{-age / eta}
  /// Grey value by tone, polarity and step.
  std::array<std::array<std::array<std::uint8_t, kSteps>, 2>, 2> grey_{};
};

}  // namespace pled
