#include "pled_vins/pipeline/line_stage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <tuple>

#include "pled_vins/pipeline/event_pictures.hpp"

namespace pled {
namespace {

constexpr double kDoubleAngle_rad = 3.0 * std::numbers::pi / 180.0;
constexpr double kDoubleOffset_px = 2.0;
constexpr double kDoubleShare = 0.5;

LinePicture kind_of(EventPicture picture) noexcept {
  return picture == EventPicture::kTimeSurface ? LinePicture::kSignedSurface : LinePicture::kGrey;
}

Segment segment_of(const LineMeasurement& line, const FlatPixels& flat) noexcept {
  const auto px = [&](const std::array<double, 2>& xy) {
    return flat.from_bearing({xy[0], xy[1]});
  };
  Segment segment;
  segment.set(px(line.bearing_xy[0]), px(line.bearing_xy[1]));
  return segment;
}

bool is_large_enough(const CameraCalibration& camera) noexcept {
  return std::min(camera.width_px, camera.height_px) >= LineDetector::kMinSide_px;
}

std::optional<Eigen::Quaterniond> in_camera(const std::optional<Eigen::Quaterniond>& R_body,
                                            const Eigen::Quaterniond& R_body_cam) noexcept {
  if (!R_body) return std::nullopt;
  return R_body_cam.conjugate() * *R_body * R_body_cam;
}

}  // namespace

LineStage::LineStage(const LineStageConfig& config, const RigCalibration& rig,
                     const LineBuffers& buffers) noexcept
    : one_camera_(rig.frame_camera == rig.event_camera),
      rectified_events_(config.event_picture == EventPicture::kTimeSurface),
      R_body_frames_(rig.cameras[rig.frame_camera].T_body_cam.q),
      R_body_events_(rig.cameras[rig.event_camera].T_body_cam.q),
      event_flat_(Camera(rig.cameras[rig.event_camera])) {
  if (from_frames(config.source) && is_large_enough(rig.cameras[rig.frame_camera]))
    frames_.emplace(config.tracking, Camera(rig.cameras[rig.frame_camera]), buffers,
                    LineRole{rig.frame_camera, LinePicture::kGrey, kFirstImageLineId});
  if (from_events(config.source) && is_large_enough(rig.cameras[rig.event_camera]))
    events_.emplace(config.tracking, picture_camera(config.event_picture, event_flat_.camera()),
                    buffers,
                    LineRole{rig.event_camera, kind_of(config.event_picture), kFirstEventLineId});
}

void LineStage::observe(const LinePictures& pictures,
                        const std::optional<Eigen::Quaterniond>& R_prev_cur_body,
                        FrameMeasurement& out) noexcept {
  if (frames_)
    follow(pictures.frame, in_camera(R_prev_cur_body, R_body_frames_), out, *frames_, frame_lines_);
  if (events_) {
    follow(pictures.events, in_camera(R_prev_cur_body, R_body_events_), out, *events_,
           event_lines_);
    if (rectified_events_)
      for (LineMeasurement& line : event_lines_.lines)
        for (std::size_t k = 0; k < line.raw_px.size(); ++k) {
          const Eigen::Vector2d raw =
              event_flat_.camera().distort({line.bearing_xy[k][0], line.bearing_xy[k][1]});
          line.raw_px[k] = {raw.x(), raw.y()};
        }
  }
  if (one_camera_) drop_doubles();
  give_out(out);
}

void LineStage::follow(ImageView<const std::uint8_t> picture,
                       const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                       const FrameMeasurement& at, LineTracker& tracker, LineFrame& out) noexcept {
  out.lines.clear();
  if (!picture.empty() && tracker.track({at.t, at.stamp_ns, picture}, at.t, R_prev_cur_cam, out))
    return;
  if (!picture.empty()) ++skipped_;
  // Nobody will say how the camera has turned between the pictures before and after.
  tracker.reset();
}

bool LineStage::one_edge(const LineMeasurement& a, const LineMeasurement& b) const noexcept {
  const Segment first = segment_of(a, event_flat_);
  const Segment second = segment_of(b, event_flat_);
  const BesideSegment at = beside(first, second);
  // Which side is the bright one may differ: events show what has changed, frames what is there.
  const double turn = std::abs(at.angle_rad());
  if (!(std::min(turn, std::numbers::pi - turn) <= kDoubleAngle_rad)) return false;
  if (!(at.common_px >= kDoubleShare * std::min(first.length_px(), second.length_px())))
    return false;
  return at.farthest_px <= kDoubleOffset_px;
}

void LineStage::drop_doubles() noexcept {
  auto& of_frames = frame_lines_.lines;
  auto& of_events = event_lines_.lines;
  for (std::size_t e = of_events.size(); e-- > 0;) {
    const auto hidden_by = [&](const LineMeasurement& line) {
      return line.track_length >= of_events[e].track_length && one_edge(line, of_events[e]);
    };
    if (std::any_of(of_frames.begin(), of_frames.end(), hidden_by)) {
      of_events.erase(e);
      continue;
    }
    for (std::size_t i = of_frames.size(); i-- > 0;)
      if (one_edge(of_frames[i], of_events[e])) of_frames.erase(i);
  }
}

void LineStage::give_out(FrameMeasurement& out) const noexcept {
  std::array<const LineMeasurement*, 2 * limits::kMaxLines> all;
  std::size_t n = 0;
  for (const LineMeasurement& line : frame_lines_.lines) all[n++] = &line;
  for (const LineMeasurement& line : event_lines_.lines) all[n++] = &line;
  // Of two as old the frame's first, then in the tracker's order, which is that of their ids.
  const auto order = [](const LineMeasurement* line) {
    return std::tuple(~line->track_length, line->id);
  };
  std::sort(
      all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n),
      [&](const LineMeasurement* a, const LineMeasurement* b) { return order(a) < order(b); });
  out.lines.clear();
  for (std::size_t i = 0; i < std::min(n, limits::kMaxLines); ++i)
    if (!out.lines.push_back(*all[i])) return;
}

void LineStage::shift_frames(Duration shift) noexcept {
  if (frames_) frames_->shift_clock(shift);
}

void LineStage::shift_events(Duration shift) noexcept {
  if (events_) events_->shift_clock(shift);
}

void LineStage::reset_events() noexcept {
  if (events_) events_->reset();
}

void LineStage::reset() noexcept {
  if (frames_) frames_->reset();
  reset_events();
}

}  // namespace pled
