#include "pled_vins/pipeline/event_points.hpp"

#include <algorithm>
#include <cmath>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

FrontendConfig tracking_of(const EventConfig& config, FrontendConfig tracking) noexcept {
  if (config.max_points > 0) tracking.max_points = config.max_points;  // else never asked
  tracking.min_distance_px = config.corner_min_distance_px;
  return tracking;
}

constexpr double kMostCornerDistance_px = 100.0;

/// The tracker scales the distance between points by itself, and has the last word.
EventConfig corners_of(EventConfig config, int width_px) noexcept {
  config.corner_min_distance_px =
      std::min(kMostCornerDistance_px, scaled_distance_px(config.corner_min_distance_px, width_px));
  return config;
}

}  // namespace

EventPoints::EventPoints(const EventConfig& config, const FrontendConfig& tracking,
                         const Camera& camera, std::uint8_t camera_index, const EventWarp& warp,
                         const FrameTrackerBuffers& buffers) noexcept
    : camera_(camera),
      warp_(warp),
      kind_(config.picture),
      detector_(corners_of(config, camera.calibration().width_px)),
      tracker_(tracking_of(config, tracking), picture_camera(config.picture, camera), buffers,
               {camera_index, FeatureKind::kEventPoint}) {}

void EventPoints::observe(const EventPictures& pictures, const TurnSlices& slices,
                          Timestamp t_event, Timestamp t, std::int64_t stamp_ns,
                          const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                          FrameMeasurement& out) noexcept {
  find_corners(pictures.surface(), slices, t_event, R_prev_cur_cam, out);
  const FrameView frame{t, stamp_ns, pictures.picture(kind_)};
  PLED_CHECK(tracker_.track(frame, t, R_prev_cur_cam, {offered_.data(), offered_.size()}, out));
  if (kind_ != EventPicture::kTimeSurface) return;
  for (PointMeasurement& point : out.points) {
    const Eigen::Vector2d raw = camera_.distort({point.bearing_xy[0], point.bearing_xy[1]});
    point.raw_px = {raw.x(), raw.y()};
  }
}

/// `last`: the points of the observation before; new corners are looked for away from them.
void EventPoints::find_corners(const ActiveSurface& surface, const TurnSlices& slices,
                               Timestamp t_event,
                               const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                               const FrameMeasurement& last) noexcept {
  std::array<Eigen::Vector2f, limits::kMaxPoints> occupied;
  std::size_t n = 0;
  for (const PointMeasurement& point : last.points) {
    Eigen::Vector3d ray(point.bearing_xy[0], point.bearing_xy[1], 1.0);
    if (R_prev_cur_cam) ray = R_prev_cur_cam->conjugate() * ray;
    if (const auto px = camera_.project(ray)) occupied[n++] = px->cast<float>();
  }
  const Timestamp t_drawn = kind_ == EventPicture::kTimeSurface ? slices.t_ref : t_event;
  detector_.detect(surface, t_drawn, std::span(occupied).first(n), limits::kMaxPoints, corners_);
  offered_.clear();
  for (const EventCorner& corner : corners_) {
    Corner place{corner.x_px, corner.y_px, 1.0F};
    if (kind_ == EventPicture::kTimeSurface) {
      const auto px = warp_.carry(Eigen::Vector2f(corner.x_px, corner.y_px), corner.t, slices);
      if (!px) continue;
      place.x_px = static_cast<std::int16_t>(std::lround(px->x()));
      place.y_px = static_cast<std::int16_t>(std::lround(px->y()));
    }
    PLED_CHECK(offered_.push_back(place));
  }
}

}  // namespace pled
