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

/// Time surfaces are drawn without the lens, because carrying events takes it away.
Camera tracking_camera(const EventConfig& config, const Camera& camera) noexcept {
  return config.picture == EventPicture::kTimeSurface ? Camera(rectified(camera.calibration()))
                                                      : camera;
}

}  // namespace

EventPoints::EventPoints(const EventConfig& config, const FrontendConfig& tracking,
                         const Camera& camera, std::uint8_t camera_index, const EventWarp& warp,
                         const EventPointBuffers& buffers) noexcept
    : camera_(camera),
      warp_(warp),
      buffers_(buffers),
      kind_(config.picture),
      surface_(config, camera.calibration().width_px, camera.calibration().height_px,
               buffers.pixels),
      brightness_(config.brightness_decay_ms, camera.calibration().width_px,
                  camera.calibration().height_px, buffers.brightness),
      drawing_(config.surface_decay_ms),
      detector_(corners_of(config, camera.calibration().width_px)),
      tracker_(tracking_of(config, tracking), tracking_camera(config, camera), buffers.tracker,
               {camera_index, FeatureKind::kEventPoint}) {}

ImageView<std::uint8_t> EventPoints::view() const noexcept {
  const CameraCalibration& c = camera_.calibration();
  return {buffers_.picture.data(), c.width_px, c.height_px, c.width_px};
}

void EventPoints::reset() noexcept {
  surface_.clear();
  brightness_.clear();
  tracker_.reset();
}

std::span<const EventVerdict> EventPoints::on_events(std::span<const Event> events) noexcept {
  PLED_CHECK(events.size() <= kRun);
  const std::span<EventVerdict> verdicts = std::span(verdicts_).first(events.size());
  const std::uint64_t restarts = surface_.counts().restarts;
  surface_.insert(events, verdicts);
  if (surface_.counts().restarts != restarts) forget_before_restart(events.size());
  if (kind_ == EventPicture::kBrightness) brightness_.insert(events, verdicts);
  return verdicts;
}

/// The active surface has begun anew in the middle of a run of events, behind some that it dropped.
void EventPoints::forget_before_restart(std::size_t run) noexcept {
  brightness_.clear();
  const std::span<EventVerdict> told = std::span(verdicts_).first(run);
  const auto last_dropped = std::find(told.rbegin(), told.rend(), EventVerdict::kDropped);
  std::fill(told.begin(), last_dropped.base(), EventVerdict::kDropped);
}

Duration EventPoints::reach() const noexcept {
  return kind_ == EventPicture::kTimeSurface ? drawing_.reach(Meeting::kBlended) : Duration{};
}

void EventPoints::draw(const TurnSlices& slices) noexcept {
  if (kind_ == EventPicture::kTimeSurface) {
    PLED_CHECK(drawing_.render(surface_, warp_, slices, SurfaceTone::kSigned, Meeting::kBlended,
                               buffers_.drawing, view()));
  } else {
    PLED_CHECK(brightness_.render(slices.t_ref, view()));
  }
}

void EventPoints::observe(const TurnSlices& slices, Timestamp t, std::int64_t stamp_ns,
                          const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                          FrameMeasurement& out) noexcept {
  find_corners(slices, R_prev_cur_cam, out);
  draw(slices);
  const FrameView frame{t, stamp_ns, view()};
  PLED_CHECK(tracker_.track(frame, t, R_prev_cur_cam, {offered_.data(), offered_.size()}, out));
  if (kind_ != EventPicture::kTimeSurface) return;
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
    Eigen::Vector3d ray(point.bearing_xy[0], point.bearing_xy[1], 1.0);
    if (R_prev_cur_cam) ray = R_prev_cur_cam->conjugate() * ray;
    if (const auto px = camera_.project(ray)) occupied[n++] = px->cast<float>();
  }
  detector_.detect(surface_, slices.t_ref, std::span(occupied).first(n), limits::kMaxPoints,
                   corners_);
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
