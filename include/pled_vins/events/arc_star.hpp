#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/events/active_surface.hpp"
#include "pled_vins/events/config.hpp"

namespace pled {

/// Nearest that an event corner may be to the sensor's edge, pixels: the larger circle's radius.
inline constexpr int kArcStarBorderPx = 4;

/// An event at which two edges meet, in raw pixels.
struct EventCorner {
  Timestamp t;
  std::int16_t x_px = 0;
  std::int16_t y_px = 0;
  Polarity polarity = Polarity::kOff;
};

/// Whether the filtered surface of a polarity has a corner at a pixel: on the circles of 16 and of
/// 20 pixels around it, the newest pixels form one arc of 3 to 6 (4 to 8) or of 10 to 13 (12 to
/// 16).
///
/// The arc starts at a circle's newest pixel and takes the newer of its two neighbours again and
/// again. The first 3 (4) belong to it; after that it ends with the last one that is not older than
/// the oldest inside. Which of equally new pixels is taken first makes no difference to the arc. A
/// pixel that never fired is older than all that did, and as old as another that never fired.
/// @param x_px, y_px  at least kArcStarBorderPx inside the sensor, which is checked: false outside
/// Source: Alzugaray and Chli, "Asynchronous corner detection and tracking for event cameras in
/// real time", RA-L 2018.
[[nodiscard]] bool is_arc_star(const ActiveSurface& surface, int x_px, int y_px,
                               Polarity polarity) noexcept;

/// Looks for new corners among the newest events.
class ArcStarDetector {
 public:
  explicit ArcStarDetector(const EventConfig& config) noexcept;

  /// Corners for new tracks, newest first. An event is a candidate when it is at most
  /// corner_max_age_ms older than t_ref, still the newest accepted one of its pixel and polarity,
  /// and the pixel has not fired in the other one since. Corners keep corner_min_distance_px from
  /// each other and from `occupied`.
  /// @param[in] occupied  raw pixels of existing tracks, at most kMaxPoints; those that are not
  ///            finite or lie outside are passed over
  /// @param[in] max_count  at most so many corners
  /// @param[out] out  written whole
  /// Cost: at most corner_max_candidates tests of some hundred instructions.
  void detect(const ActiveSurface& surface, Timestamp t_ref,
              std::span<const Eigen::Vector2f> occupied, std::size_t max_count,
              FixedVector<EventCorner, limits::kMaxPoints>& out) noexcept;

 private:
  struct Place {
    float x_px = 0.0F;
    float y_px = 0.0F;
    std::uint16_t next = 0;  ///< in the same cell, 0: none, else 1 + index
  };

  void lay_grid(int width_px, int height_px) noexcept;
  void occupy(float x_px, float y_px) noexcept;
  [[nodiscard]] bool is_free(float x_px, float y_px) const noexcept;
  [[nodiscard]] int cell_of(float px) const noexcept;

  float min_distance_px_;
  std::uint32_t max_age_us_;
  std::size_t max_candidates_;
  float cell_px_ = 0.0F;
  int columns_ = 0;
  int rows_ = 0;
  std::array<std::uint16_t, limits::kMaxEventCells>
      cells_;  ///< first Place, 0: none, else 1 + index
  FixedVector<Place, 2 * limits::kMaxPoints> places_;
};

}  // namespace pled
