#include "pled_vins/frontend/lines/line_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

/// Pictures for which a line that is not seen is kept: LSD drops one now and then.
constexpr int kMaxMissed = 2;
/// Motion is not carried on over longer gaps.
constexpr double kMaxStep_s = 0.2;
/// Farther off than this a line has not gone on: it is another edge.
constexpr double kJump_px = 2.0;
constexpr double kJump_rad = 2.0 * std::numbers::pi / 180.0;
/// Shortest depth of a bearing after it was turned: beyond 84 degrees it has left any picture.
constexpr double kMinDepth = 0.1;
constexpr double kReferenceWidth_px = 240.0;
constexpr double kMaxSearchScale = 3.0;

/// Cosine of the largest turn between two sights over which a motion across is told.
constexpr double kMinAlike = 0.5;

[[nodiscard]] bool usable(const std::optional<Eigen::Quaterniond>& q) noexcept {
  return q && std::abs(q->norm() - 1.0) < 1e-3;  // false for NaN
}

/// Written so that NaN counts.
bool has_jumped(const BesideSegment& at) noexcept {
  return !(std::abs(at.offset_px) <= kJump_px && std::abs(at.angle_rad()) <= kJump_rad);
}

using Ends = std::array<std::array<double, 2>, 2>;

/// Normal of the line through two bearings, unit length; 0 if they are one.
Eigen::Vector2d normal_of(const Ends& ends) noexcept {
  const Eigen::Vector2d along(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
  return Eigen::Vector2d(along.y(), -along.x()) / std::max(along.norm(), 1e-12);
}

/// How fast each end goes along the line's normal if what was the line through `before` has become
/// that through `now`: e - s n lies on the earlier line, s = m . (e - p) / (m . n).
Ends rates_across(const Ends& before, const Ends& now, double dt_s) noexcept {
  const Eigen::Vector2d n = normal_of(now);
  const Eigen::Vector2d m = normal_of(before);
  const double alike = m.dot(n);
  Ends rates{};
  if (!(dt_s > 0.0 && std::abs(alike) >= kMinAlike)) return rates;
  const Eigen::Vector2d p(before[0][0], before[0][1]);
  for (std::size_t k = 0; k < rates.size(); ++k) {
    const double s = m.dot(Eigen::Vector2d(now[k][0], now[k][1]) - p) / alike;
    rates[k] = {s / dt_s * n.x(), s / dt_s * n.y()};
  }
  return rates;
}

}  // namespace

LineTracker::LineTracker(const LineConfig& config, const Camera& camera, const LineBuffers& buffers,
                         const LineRole& role) noexcept
    : config_(config),
      role_(role),
      detector_(config, camera, role.picture, buffers),
      search_px_(config.search_px * std::clamp(camera.calibration().width_px / kReferenceWidth_px,
                                               1.0, kMaxSearchScale)),
      next_id_(role.first_id) {}

bool LineTracker::track(const FrameView& frame, Timestamp t_imu,
                        const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                        LineFrame& out) noexcept {
  out.t = t_imu;
  out.stamp_ns = frame.stamp_ns;
  out.lines.clear();
  out.lost = 0;
  if (!detector_.detect(frame.image, seen_)) return false;

  double dt_s = t_previous_ ? (t_imu - *t_previous_).seconds() : 0.0;
  if (!(dt_s > 0.0 && dt_s <= kMaxStep_s)) dt_s = 0.0;
  Eigen::Matrix3d R_cur_prev = Eigen::Matrix3d::Identity();
  if (t_previous_ && usable(R_prev_cur_cam))
    R_cur_prev = R_prev_cur_cam->normalized().toRotationMatrix().transpose();
  t_previous_ = t_imu;
  lost_ = 0;
  expect_all(R_cur_prev, dt_s);

  take_matches(t_imu, dt_s);
  end_missing();
  begin_tracks(t_imu);
  write(out);
  return true;
}

void LineTracker::shift_clock(Duration shift) noexcept {
  if (t_previous_) t_previous_ = *t_previous_ + shift;
  for (std::size_t i = 0; i < num_tracks_; ++i) {
    Track& track = tracks_[i];
    track.t_seen = track.t_seen + shift;
    track.has_motion = false;
    track.across_pxps = 0.0;
  }
}

void LineTracker::reset() noexcept {
  num_tracks_ = 0;
  t_previous_.reset();
}

bool LineTracker::turn(const Eigen::Matrix3d& R_cur_prev, Segment& segment) const noexcept {
  const FlatPixels& flat = detector_.flat();
  const Eigen::Vector3d start = R_cur_prev * flat.bearing(segment.start()).homogeneous();
  const Eigen::Vector3d end = R_cur_prev * flat.bearing(segment.end()).homogeneous();
  if (!(start.z() > kMinDepth && end.z() > kMinDepth)) return false;
  segment.set(flat.from_bearing(start.hnormalized()), flat.from_bearing(end.hnormalized()));
  return true;
}

void LineTracker::expect_all(const Eigen::Matrix3d& R_cur_prev, double dt_s) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < num_tracks_; ++i) {
    Segment segment = tracks_[i].line.segment;
    if (!turn(R_cur_prev, segment)) {
      ++lost_;
      continue;
    }
    if (kept != i) tracks_[kept] = tracks_[i];
    const Track& track = tracks_[kept];
    moved_px_[kept] = track.across_pxps * dt_s;
    const Eigen::Vector2d way = moved_px_[kept] * segment.normal();
    segment.set(segment.start() + way, segment.end() + way);
    expected_[kept] = {segment, track.line.descriptor, track.missed == 0};
    ++kept;
  }
  num_tracks_ = kept;
}

LineTracker::Ends LineTracker::bearings_of(const Segment& segment) const noexcept {
  const Eigen::Vector2d start = detector_.flat().bearing(segment.start());
  const Eigen::Vector2d end = detector_.flat().bearing(segment.end());
  return {{{start.x(), start.y()}, {end.x(), end.y()}}};
}

void LineTracker::take_matches(Timestamp t, double dt_s) noexcept {
  std::array<std::int16_t, limits::kMaxLines> match;
  match_lines(std::span(expected_).first(num_tracks_), seen_.span(), search_px_,
              std::span(match).first(num_tracks_));
  is_known_.fill(false);
  for (std::size_t i = 0; i < num_tracks_; ++i) {
    Track& track = tracks_[i];
    if (match[i] == kNoLine) {
      ++track.missed;
      track.line.segment = expected_[i].segment;
      continue;
    }
    const auto k = static_cast<std::size_t>(match[i]);
    const BesideSegment at = beside(expected_[i].segment, seen_[k].segment);
    if (track.has_motion && dt_s > 0.0 && has_jumped(at)) {
      track.missed = kMaxMissed + 1;  // ends; what is seen begins anew
      continue;
    }
    is_known_[k] = true;
    if (dt_s > 0.0) {
      track.across_pxps = (moved_px_[i] + at.offset_px / (track.missed + 1)) / dt_s;
      track.has_motion = true;
    }
    track.line = seen_[k];
    const Ends ends = bearings_of(track.line.segment);
    track.bearing_rate_xyps = rates_across(track.bearing_xy, ends, (t - track.t_seen).seconds());
    track.bearing_xy = ends;
    track.t_seen = t;
    track.missed = 0;
    ++track.length;
  }
}

void LineTracker::end_missing() noexcept {
  for (std::size_t i = num_tracks_; i-- > 0;)
    if (tracks_[i].missed > kMaxMissed) end(i);
  // What is seen goes before what may come back; of that the older.
  const auto known = static_cast<std::size_t>(std::count(is_known_.begin(), is_known_.end(), true));
  const std::size_t fresh = seen_.size() - known;
  for (std::size_t i = num_tracks_; i-- > 0;)
    if (tracks_[i].missed > 0 && num_tracks_ + fresh > static_cast<std::size_t>(config_.max_lines))
      end(i);
}

void LineTracker::end(std::size_t i) noexcept {
  const auto first = tracks_.begin() + static_cast<std::ptrdiff_t>(i);
  std::copy(first + 1, tracks_.begin() + static_cast<std::ptrdiff_t>(num_tracks_), first);
  --num_tracks_;
  ++lost_;
}

void LineTracker::begin_tracks(Timestamp t) noexcept {
  for (std::size_t k = 0; k < seen_.size(); ++k) {
    if (is_known_[k]) continue;
    PLED_CHECK(num_tracks_ < tracks_.size());
    Track track;
    track.id = next_id_++;
    track.line = seen_[k];
    track.bearing_xy = bearings_of(track.line.segment);
    track.t_seen = t;
    tracks_[num_tracks_++] = track;
  }
}

void LineTracker::write(LineFrame& out) const noexcept {
  for (std::size_t i = 0; i < num_tracks_; ++i) {
    const Track& track = tracks_[i];
    if (track.missed > 0) continue;
    LineMeasurement line;
    line.id = track.id;
    line.camera = role_.camera_index;
    line.track_length = track.length;
    line.length_px = track.line.segment.length_px();
    line.raw_px = track.line.raw_px;
    line.bearing_xy = track.bearing_xy;
    line.bearing_rate_xyps = track.bearing_rate_xyps;
    PLED_CHECK(out.lines.push_back(line));
  }
  out.lost = lost_;
}

}  // namespace pled
