#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/events/arc_star.hpp"
#include "pled_vins/events/config.hpp"
#include "pled_vins/events/event_warp.hpp"
#include "pled_vins/frontend/frame_tracker.hpp"
#include "pled_vins/pipeline/event_pictures.hpp"

namespace pled {

/// Event corners and their tracks: points are followed from the picture of one observation into
/// that of the next.
class EventPoints {
 public:
  /// @param camera  of the events, lens included; @param warp  to rectified(camera). Both outlive
  ///        this object, as do the buffers
  /// @param buffers  without those for finding corners
  EventPoints(const EventConfig& config, const FrontendConfig& tracking, const Camera& camera,
              std::uint8_t camera_index, const EventWarp& warp,
              const FrameTrackerBuffers& buffers) noexcept;

  /// Follows the points to the observation and looks for new ones.
  /// @param pictures  with that of the observation drawn in kind()
  /// @param slices  turning over pictures.reach(), to the observation (event camera's clock)
  /// @param t_event  the observation on the event camera's clock; @param t  on the estimator's
  /// @param R_prev_cur_cam  as for FrameTracker::track
  /// @param out     written whole, but read first: it must hold the last observation. Pixels are
  ///        those of the sensor, lens included
  void observe(const EventPictures& pictures, const TurnSlices& slices, Timestamp t_event,
               Timestamp t, std::int64_t stamp_ns,
               const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
               FrameMeasurement& out) noexcept;

  void shift_clock(Duration shift) noexcept { tracker_.shift_clock(shift); }
  void reset() noexcept { tracker_.reset(); }

  /// The picture that points are followed in.
  [[nodiscard]] EventPicture kind() const noexcept { return kind_; }

 private:
  void find_corners(const ActiveSurface& surface, const TurnSlices& slices, Timestamp t_event,
                    const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                    const FrameMeasurement& last) noexcept;

  const Camera& camera_;
  const EventWarp& warp_;
  EventPicture kind_;
  ArcStarDetector detector_;
  FrameTracker tracker_;
  FixedVector<EventCorner, limits::kMaxPoints> corners_;
  FixedVector<Corner, limits::kMaxPoints> offered_;
};

}  // namespace pled
