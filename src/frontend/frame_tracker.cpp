#include "pled_vins/frontend/frame_tracker.hpp"

#include <algorithm>
#include <cmath>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

/// Corners weaker than this are noise whatever the best one is, (grey/px)^2.
constexpr float kMinCornerScore = 1.0F;
/// Two tracks that came closer than this share of the minimum distance look at the same thing.
constexpr double kCrowdedShare = 0.5;
constexpr double kReferenceWidthPx = 240.0;
constexpr double kMaxDistanceScale = 3.0;

/// Upper median of `count` values; 0 when there are none. Reorders them.
[[nodiscard]] double median(std::array<double, limits::kMaxPoints>& values,
                            std::size_t count) noexcept {
  if (count == 0) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(values.begin(), middle, values.begin() + static_cast<std::ptrdiff_t>(count));
  return *middle;
}

[[nodiscard]] bool usable(const std::optional<Eigen::Quaterniond>& q) noexcept {
  return q && std::abs(q->norm() - 1.0) < 1e-3;  // false for NaN
}

}  // namespace

double scaled_distance_px(double distance_px, int width_px) noexcept {
  return distance_px * std::clamp(width_px / kReferenceWidthPx, 1.0, kMaxDistanceScale);
}

FrameTracker::FrameTracker(const FrontendConfig& config, const Camera& camera,
                           const FrameTrackerBuffers& buffers, const TrackerRole& role) noexcept
    : config_(config),
      camera_(camera),
      role_(role),
      buffers_(buffers),
      min_distance_px_(scaled_distance_px(config.min_distance_px, camera.calibration().width_px)),
      follower_(config, camera, buffers.reference_patches, role.kind),
      motion_(camera.focal_px(), config.ransac_px),
      next_id_(role.kind == FeatureKind::kEventPoint ? kFirstEventPointId : 1) {
  const CameraCalibration& c = camera.calibration();
  PLED_CHECK(check(config).key == nullptr);
  PLED_CHECK(c.width_px > 0 && c.width_px <= buffers.max_width_px);
  PLED_CHECK(c.height_px > 0 && c.height_px <= buffers.max_height_px);
  for (std::size_t k = 0; k < pyramids_.size(); ++k)
    pyramids_[k] =
        lay_out_pyramid(buffers.pyramids[k], c.width_px, c.height_px, config.pyramid_levels);
}

bool FrameTracker::track(const FrameView& frame, Timestamp t_imu,
                         const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                         FrameMeasurement& out) noexcept {
  if (!follow_into(frame, t_imu, R_prev_cur_cam, out)) return false;
  find_corners();
  begin_tracks();
  write(out);
  return true;
}

bool FrameTracker::track(const FrameView& frame, Timestamp t_imu,
                         const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                         std::span<const Corner> offered, FrameMeasurement& out) noexcept {
  if (!follow_into(frame, t_imu, R_prev_cur_cam, out)) return false;
  choose_from(offered);
  begin_tracks();
  write(out);
  return true;
}

bool FrameTracker::follow_into(const FrameView& frame, Timestamp t_imu,
                               const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                               FrameMeasurement& out) noexcept {
  out.t = t_imu;
  out.stamp_ns = frame.stamp_ns;
  out.points.clear();
  out.median_flow_px = 0.0;
  out.median_parallax_px = 0.0;
  out.lost = 0;
  const ImageView<std::int16_t>& size = pyramids_[0].levels[0];
  if (frame.image.empty() || frame.image.width != size.width || frame.image.height != size.height ||
      frame.image.stride < frame.image.width)
    return false;

  current_ = 1 - current_;
  build_pyramid(frame.image, buffers_.row, pyramids_[current_]);
  lost_ = 0;
  const std::optional<Eigen::Quaterniond> rotation =
      t_previous_ && usable(R_prev_cur_cam) ? R_prev_cur_cam : std::nullopt;
  if (t_previous_) {
    FramePair frames{&pyramids_[1 - current_], &pyramids_[current_]};
    if (rotation) frames.R_prev_cur = rotation->normalized().toRotationMatrix();
    frames.dt_s = (t_imu - *t_previous_).seconds();
    follow_all(frames);
    drop_crowded();
  }
  t_previous_ = t_imu;
  motion_.advance(t_imu, rotation);
  motion_.judge(tracks());
  drop_struck_out();
  return true;
}

void FrameTracker::shift_clock(Duration shift) noexcept {
  if (t_previous_) t_previous_ = *t_previous_ + shift;
  motion_.forget_past();
}

void FrameTracker::reset() noexcept {
  num_tracks_ = 0;
  follower_.end_all();
  motion_.reset();
  t_previous_.reset();
}

template <typename Keep>
void FrameTracker::keep_if(const Keep& keep) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < num_tracks_; ++i) {
    if (!keep(i)) {
      follower_.end(tracks_[i]);
      ++lost_;
      continue;
    }
    if (kept != i) tracks_[kept] = tracks_[i];
    ++kept;
  }
  num_tracks_ = kept;
}

void FrameTracker::follow_all(const FramePair& frames) noexcept {
  keep_if([&](std::size_t i) { return follower_.follow(frames, tracks_[i]); });
}

/// Of two tracks on one spot the older stays.
void FrameTracker::drop_crowded() noexcept {
  const double nearest = kCrowdedShare * min_distance_px_;
  std::array<bool, limits::kMaxPoints> crowded{};
  for (std::size_t i = 0; i < num_tracks_; ++i)
    for (std::size_t k = 0; k < i && !crowded[i]; ++k)
      crowded[i] = !crowded[k] && (tracks_[i].px - tracks_[k].px).squaredNorm() < nearest * nearest;
  keep_if([&](std::size_t i) { return !crowded[i]; });
}

void FrameTracker::drop_struck_out() noexcept {
  keep_if([&](std::size_t i) { return !TrackMotion::is_struck_out(tracks_[i]); });
}

void FrameTracker::find_corners() noexcept {
  corners_.clear();
  const auto wanted = static_cast<std::size_t>(config_.max_points);
  if (num_tracks_ >= wanted) return;
  const ImageView<std::int16_t>& level = pyramids_[current_].levels[0];
  const ImageView<float> response{buffers_.response.data(), level.width, level.height, level.width};
  const ImageView<std::uint8_t> mask{buffers_.mask.data(), level.width, level.height, level.width};
  corner_response(level, buffers_.corner_rows, response);
  std::fill_n(mask.data, static_cast<std::size_t>(level.width * level.height), std::uint8_t{0});
  std::array<Corner, limits::kMaxPoints> occupied;
  for (std::size_t i = 0; i < num_tracks_; ++i) {
    const Eigen::Vector2f px = tracks_[i].px.cast<float>();
    paint_disc(mask, px.x(), px.y(), static_cast<float>(min_distance_px_));
    occupied[i] = {static_cast<std::int16_t>(px.x()), static_cast<std::int16_t>(px.y()), 0.0F};
  }
  const float best = *std::max_element(
      response.data, response.data + static_cast<std::ptrdiff_t>(level.width) * level.height);
  const CornerDemand demand{
      wanted - num_tracks_,
      std::max(kMinCornerScore, static_cast<float>(config_.corner_quality) * best),
      static_cast<float>(min_distance_px_), wanted};
  select_corners(response, mask, std::span(occupied).first(num_tracks_), demand,
                 buffers_.corner_cells, corners_);
}

void FrameTracker::choose_from(std::span<const Corner> offered) noexcept {
  corners_.clear();
  const auto wanted = static_cast<std::size_t>(config_.max_points);
  const double min_square = min_distance_px_ * min_distance_px_;
  for (const Corner& corner : offered) {
    if (num_tracks_ + corners_.size() >= wanted) return;
    const Eigen::Vector2d px(corner.x_px, corner.y_px);
    if (!camera_.inside(px, kCornerBorderPx)) continue;
    const auto near_track = [&](const PointTrack& t) {
      return (t.px - px).squaredNorm() < min_square;
    };
    const auto near_corner = [&](const Corner& c) {
      return (Eigen::Vector2d(c.x_px, c.y_px) - px).squaredNorm() < min_square;
    };
    if (std::any_of(tracks_.begin(), tracks_.begin() + static_cast<std::ptrdiff_t>(num_tracks_),
                    near_track) ||
        std::any_of(corners_.begin(), corners_.end(), near_corner))
      continue;
    PLED_CHECK(corners_.push_back(corner));
  }
}

void FrameTracker::begin_tracks() noexcept {
  for (const Corner& corner : corners_) {
    PointTrack track;
    track.px = Eigen::Vector2d(corner.x_px, corner.y_px);
    const std::optional<Eigen::Vector2d> bearing = camera_.undistort(track.px);
    if (!bearing || !follower_.begin(pyramids_[current_], track)) continue;
    track.bearing = *bearing;
    track.id = next_id_++;
    tracks_[num_tracks_++] = track;
  }
  motion_.file_bearings(tracks());
}

void FrameTracker::write(FrameMeasurement& out) const noexcept {
  std::array<double, limits::kMaxPoints> flow;
  std::array<double, limits::kMaxPoints> parallax;
  std::size_t followed = 0;
  for (std::size_t i = 0; i < num_tracks_; ++i) {
    const PointTrack& track = tracks_[i];
    PointMeasurement point;
    point.id = track.id;
    point.kind = role_.kind;
    point.camera = role_.camera_index;
    point.inlier = track.inlier;
    point.track_length = track.length;
    point.raw_px = {track.px.x(), track.px.y()};
    point.bearing_xy = {track.bearing.x(), track.bearing.y()};
    point.bearing_rate_xyps = {track.bearing_rate_ps.x(), track.bearing_rate_ps.y()};
    PLED_CHECK(out.points.push_back(point));
    if (track.length < 2) continue;
    flow[followed] = track.flow_px;
    parallax[followed++] = track.parallax_px.norm();
  }
  out.median_flow_px = median(flow, followed);
  out.median_parallax_px = median(parallax, followed);
  out.lost = lost_;
}

}  // namespace pled
