#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Geometry>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/events/active_surface.hpp"
#include "pled_vins/events/arc_star.hpp"
#include "pled_vins/events/config.hpp"
#include "pled_vins/events/event_warp.hpp"
#include "pled_vins/events/time_surface.hpp"
#include "pled_vins/frontend/frame_tracker.hpp"

namespace pled {

/// The memory that event points need, whatever the sensor's size.
struct EventPointBuffers {
  std::span<SurfacePixel> pixels;
  std::span<std::uint16_t> keys;      ///< one per pixel
  std::span<std::uint8_t> surface;    ///< one per pixel
  FrameTrackerBuffers tracker;        ///< without those for finding corners
};

/// Event corners and their tracks: at each observation the active surface, compensated for the
/// camera's turning, is drawn as a picture and the points are followed from the last such picture.
class EventPoints {
 public:
  /// @param camera  of the events, lens included; @param warp  to rectified(camera). Both outlive
  ///        this object, as do the buffers
  EventPoints(const EventConfig& config, const FrontendConfig& tracking, const Camera& camera,
              std::uint8_t camera_index, const EventWarp& warp,
              const EventPointBuffers& buffers) noexcept;

  /// Events in time order, up to the next observation.
  void on_events(std::span<const Event> events) noexcept { surface_.insert(events); }

  /// How long before an observation an event can still be seen in the picture.
  [[nodiscard]] Duration horizon() const noexcept { return drawing_.horizon(); }

  /// Follows the points to the observation and looks for new ones.
  /// @param slices  turning over the horizon, to the observation (event camera's clock)
  /// @param t       the observation on the estimator clock
  /// @param R_prev_cur_cam  as for FrameTracker::track
  /// @param out     written whole; pixels are those of the sensor, lens included
  void observe(const TurnSlices& slices, Timestamp t, std::int64_t stamp_ns,
               const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
               FrameMeasurement& out) noexcept;

  void shift_clock(Duration shift) noexcept { tracker_.shift_clock(shift); }
  void reset() noexcept;

  /// The picture of the last observation, in rectified pixels.
  [[nodiscard]] ImageView<const std::uint8_t> picture() const noexcept;
  [[nodiscard]] SurfaceCounts counts() const noexcept { return surface_.counts(); }

 private:
  void find_corners(const TurnSlices& slices,
                    const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                    const FrameMeasurement& last) noexcept;

  const Camera& camera_;
  const EventWarp& warp_;
  EventPointBuffers buffers_;
  ActiveSurface surface_;
  TimeSurface drawing_;
  ArcStarDetector detector_;
  FrameTracker tracker_;
  FixedVector<EventCorner, limits::kMaxPoints> corners_;
  FixedVector<Corner, limits::kMaxPoints> offered_;
};

}  // namespace pled
