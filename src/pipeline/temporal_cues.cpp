#include "pled_vins/pipeline/temporal_cues.hpp"

#include "pled_vins/imu/dead_reckoning.hpp"
#include "pled_vins/reliability/event_count.hpp"

namespace pled {

TemporalCues::TemporalCues(const MotionCueConfig& config, const RigCalibration& rig,
                           bool read_map) noexcept
    : rig_(rig), read_map_(read_map), motion_(config, rig) {}

std::span<const TemporalWeights> TemporalCues::judge(const FrameMeasurement& frame,
                                                     const ImuHistory& imu,
                                                     const std::optional<NavState>& known,
                                                     const EventStage* events) noexcept {
  const auto times = motion_.times(frame.t);
  std::array<Pose, limits::kCueFrames + 1> path;
  std::size_t poses = 0;
  if (known && dead_reckon(imu, *known, rig_.imu.gravity_mps2, {times.data(), times.size()}, path))
    poses = times.size();
  motion_.judge(frame, std::span(path).first(poses), evidence_);
  const std::span<TemporalWeights> out = std::span(weights_).first(frame.points.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = {};
    out[i].motion = evidence_[i].w_static;
  }
  if (read_map_ && events != nullptr) read_map(frame, *events);
  return out;
}

/// Where a point is seen in the event camera: its bearing turned exactly, moved by the baseline as
/// far as its depth is known, else as if it were infinitely far.
void TemporalCues::read_map(const FrameMeasurement& frame, const EventStage& events) noexcept {
  const Pose T_event_body = rig_.cameras[rig_.event_camera].T_body_cam.inverse();
  for (std::size_t i = 0; i < frame.points.size(); ++i) {
    const PointMeasurement& p = frame.points[i];
    const Pose T = T_event_body * rig_.cameras[p.camera].T_body_cam;
    Eigen::Vector3d ray = T.q * Eigen::Vector3d(p.bearing_xy[0], p.bearing_xy[1], 1.0);
    if (evidence_[i].frames > 0) ray += evidence_[i].inverse_depth_pm * T.p;
    const std::optional<PixelScore> score =
        events.score(ray, ScorePooling::kPixel, ScoreForm::kPaper);
    if (!score) continue;
    weights_[i].paper = temporal_reliability(*score);
    weights_[i].count = event_count_reliability(score->n);
  }
}

}  // namespace pled
