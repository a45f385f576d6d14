#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Geometry>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/events/active_surface.hpp"
#include "pled_vins/events/arc_star.hpp"
#include "pled_vins/events/brightness_surface.hpp"
#include "pled_vins/events/config.hpp"
#include "pled_vins/events/event_warp.hpp"
#include "pled_vins/events/time_surface.hpp"
#include "pled_vins/frontend/frame_tracker.hpp"

namespace pled {

/// The memory that event points need, whatever the sensor's size.
struct EventPointBuffers {
  std::span<SurfacePixel> pixels;         ///< one per pixel
  std::span<BrightnessPixel> brightness;  ///< one per pixel
  std::span<float> drawing;               ///< TimeSurface::floats_needed; may be the same memory
  std::span<std::uint8_t> picture;        ///< one per pixel
  FrameTrackerBuffers tracker;            ///< without those for finding corners
};

/// Event corners and their tracks: at each observation the events are drawn as a picture, and the
/// points are followed into it from the last one.
class EventPoints {
 public:
  /// @param camera  of the events, lens included; @param warp  to rectified(camera). Both outlive
  ///        this object, as do the buffers
  EventPoints(const EventConfig& config, const FrontendConfig& tracking, const Camera& camera,
              std::uint8_t camera_index, const EventWarp& warp,
              const EventPointBuffers& buffers) noexcept;

  /// At most so many events at a time.
  static constexpr std::size_t kRun = 1024;

  /// Events in time order, up to the next observation.
  /// @returns what the surface thinks of each; valid until the next call
  std::span<const EventVerdict> on_events(std::span<const Event> events) noexcept;

  /// How long before an observation its events need slices that carry them to it; nothing for a
  /// picture that needs none.
  [[nodiscard]] Duration reach() const noexcept;

  /// Follows the points to the observation and looks for new ones.
  /// @param slices  turning over reach(), to the observation (event camera's clock)
  /// @param t       the observation on the estimator clock
  /// @param R_prev_cur_cam  as for FrameTracker::track
  /// @param out     written whole, but read first: it must hold the last observation. Pixels are
  ///        those of the sensor, lens included
  void observe(const TurnSlices& slices, Timestamp t, std::int64_t stamp_ns,
               const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
               FrameMeasurement& out) noexcept;

  void shift_clock(Duration shift) noexcept { tracker_.shift_clock(shift); }
  void reset() noexcept;

  /// The picture of the last observation: in sensor pixels, or rectified if a time surface.
  [[nodiscard]] ImageView<const std::uint8_t> picture() const noexcept { return view(); }
  [[nodiscard]] SurfaceCounts counts() const noexcept { return surface_.counts(); }

 private:
  [[nodiscard]] ImageView<std::uint8_t> view() const noexcept;
  void forget_before_restart(std::size_t run) noexcept;
  void draw(const TurnSlices& slices) noexcept;
  void find_corners(const TurnSlices& slices,
                    const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                    const FrameMeasurement& last) noexcept;

  const Camera& camera_;
  const EventWarp& warp_;
  EventPointBuffers buffers_;
  EventPicture kind_;
  ActiveSurface surface_;
  BrightnessSurface brightness_;
  TimeSurface drawing_;
  ArcStarDetector detector_;
  FrameTracker tracker_;
  std::array<EventVerdict, kRun> verdicts_{};
  FixedVector<EventCorner, limits::kMaxPoints> corners_;
  FixedVector<Corner, limits::kMaxPoints> offered_;
};

}  // namespace pled
