#include "pled_vins/pipeline/event_points.hpp"

#include <array>
#include <cmath>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

FrontendConfig surface_tracking(const EventConfig& config, FrontendConfig tracking) noexcept {
  if (config.max_points > 0) tracking.max_points = config.max_points;  // else never asked
  tracking.min_distance_px = config.corner_min_distance_px;
  return tracking;
}

}  // namespace

EventPoints::EventPoints(const EventConfig& config, const FrontendConfig& tracking,
                         const Camera& camera, std::uint8_t camera_index, const EventWarp& warp,
                         const EventPointBuffers& buffers) noexcept
    : camera_(camera),
      warp_(warp),
      buffers_(buffers),
      surface_(config, camera.calibration().width_px, camera.calibration().height_px,
               buffers.pixels),
      drawing_(config.surface_decay_ms),
      detector_(config),
      tracker_(surface_tracking(config, tracking), Camera(rectified(camera.calibration())),
               buffers.tracker, {camera_index, FeatureKind::kEventPoint}) {}

ImageView<const std::uint8_t> EventPoints::picture() const noexcept {
  return {buffers_.surface.data(), warp_.width_px(), warp_.height_px(), warp_.width_px()};
}

void EventPoints::reset() noexcept {
  surface_.clear();
  tracker_.reset();
}

void EventPoints::observe(const TurnSlices& slices, Timestamp t, std::int64_t stamp_ns,
                          const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                          FrameMeasurement& out) noexcept {
  find_corners(slices, R_prev_cur_cam, out);
  const ImageView<std::uint8_t> picture{buffers_.surface.data(), warp_.width_px(),
                                        warp_.height_px(), warp_.width_px()};
  PLED_CHECK(drawing_.render(surface_, warp_, slices, SurfaceTone::kSigned, HoleFill::kBetween,
                             buffers_.keys, picture));
  const FrameView frame{t, stamp_ns, picture};
  PLED_CHECK(tracker_.track(frame, t, R_prev_cur_cam, {offered_.data(), offered_.size()}, out));
  for (PointMeasurement& point : out.points) {
    const Eigen::Vector2d raw = camera_.distort({point.bearing_xy[0], point.bearing_xy[1]});
    point.raw_px = {raw.x(), raw.y()};
  }
}

/// `last`: the points of the observation before; new corners are looked for away from them.
void EventPoints::find_corners(const TurnSlices& slices,
                               const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                               const FrameMeasurement& last) noexcept {
  std::array<Eigen::Vector2f, limits::kMaxPoints> occupied;
  std::size_t n = 0;
  for (const PointMeasurement& point : last.points) {
    if (point.kind != FeatureKind::kEventPoint) continue;
    Eigen::Vector3d ray(point.bearing_xy[0], point.bearing_xy[1], 1.0);
    if (R_prev_cur_cam) ray = R_prev_cur_cam->conjugate() * ray;
    if (const auto px = camera_.project(ray)) occupied[n++] = px->cast<float>();
  }
  detector_.detect(surface_, slices.t_ref, std::span(occupied).first(n), limits::kMaxPoints,
                   corners_);
  offered_.clear();
  for (const EventCorner& corner : corners_) {
    const auto px =
        warp_.carry(Eigen::Vector2f(corner.x_px, corner.y_px), corner.t, slices);
    if (!px) continue;
    PLED_CHECK(offered_.push_back({static_cast<std::int16_t>(std::lround(px->x())),
                                   static_cast<std::int16_t>(std::lround(px->y())), 1.0F}));
  }
}

}  // namespace pled
