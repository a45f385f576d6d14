#include "pled_vins/pipeline/temporal_cues.hpp"

#include <algorithm>

#include "pled_vins/frontend/epipolar_fit.hpp"
#include "pled_vins/geometry/so3.hpp"
#include "pled_vins/imu/dead_reckoning.hpp"
#include "pled_vins/reliability/event_count.hpp"

namespace pled {
namespace {

constexpr double kGate_px = 1.5;
constexpr std::size_t kFewestPairs = 15;
/// What a gyro that nobody has calibrated yet may be off by.
constexpr double kGyroBias_radps = 0.03;
/// Any speed fits as well; this one lets depths of 0.2 m and more at a walk be fitted.
constexpr double kGuessedSpeed_mps = 1.0;

}  // namespace

TemporalCues::TemporalCues(const MotionCueConfig& config, const RigCalibration& rig,
                           bool read_map) noexcept
    : rig_(rig),
      read_map_(read_map),
      motion_(config, rig),
      lines_(config, rig),
      checks_{MotionCheck(mean_focal_px(rig.cameras[0]), kGate_px),
              MotionCheck(mean_focal_px(rig.cameras[rig.num_cameras - 1]), kGate_px)} {}

void TemporalCues::reset() noexcept {
  motion_.reset();
  lines_.reset();
  for (MotionCheck& check : checks_) check.reset();
}

std::span<const TemporalWeights> TemporalCues::judge(const FrameMeasurement& frame,
                                                     const ImuHistory& imu,
                                                     const std::optional<NavState>& known,
                                                     const Eigen::Vector3d& gyro_bias_radps,
                                                     const EventStage* events) noexcept {
  const auto times = motion_.times(frame.t);
  const std::span<const Timestamp> t{times.data(), times.size()};
  Path path;
  std::size_t poses = 0;
  if (known) poses = dead_reckon(imu, *known, rig_.imu.gravity_mps2, t, path);
  const bool metric = poses >= 2;
  if (!metric) poses = guess_path(frame, t, imu, gyro_bias_radps, path);
  motion_.judge(frame, std::span(path).first(poses), metric, evidence_);
  lines_.judge(frame, std::span(path).first(poses), metric, evidence_);
  const std::span<TemporalWeights> out = std::span(weights_).first(frame.points.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = {};
    out[i].motion = evidence_[i].w_static;
  }
  if (read_map_ && events != nullptr) {
    read_map(frame, *events);
    std::optional<Eigen::Quaterniond> R_last_now;
    if (t.size() > 1) R_last_now = imu.rotation(t[1], t[0], gyro_bias_radps);
    lines_.read_map(frame, motion_, evidence_, R_last_now, *events);
  }
  return out;
}

void TemporalCues::write(TemporalScore score, FrameMeasurement& frame) const noexcept {
  for (std::size_t i = 0; i < frame.points.size(); ++i)
    frame.points[i].w_temporal = weights_[i].of(score);
  for (std::size_t i = 0; i < lines().size(); ++i) {
    frame.lines[i].w_temporal = lines()[i].of(score);
    frame.lines[i].alpha_line = lines_.alpha(i, score);
  }
}

/// Bearings then and now of the points of one camera that have been seen for so many frames.
std::size_t TemporalCues::pairs_back(const FrameMeasurement& frame, std::size_t back,
                                     std::uint8_t camera) noexcept {
  std::size_t n = 0;
  for (std::size_t i = 0; i < frame.points.size(); ++i) {
    const PointMeasurement& p = frame.points[i];
    if (p.camera != camera || p.track_length <= back) continue;
    const std::optional<Eigen::Vector2d> then = motion_.bearing(p.id, back - 1, i);
    if (then) pairs_[n++] = {then->x(), then->y(), p.bearing_xy[0], p.bearing_xy[1]};
  }
  return n;
}

/// Poses at the given times (now first) in the frame of the body now, up to scale. Ours.
std::size_t TemporalCues::guess_path(const FrameMeasurement& frame,
                                     std::span<const Timestamp> times, const ImuHistory& imu,
                                     const Eigen::Vector3d& gyro_bias_radps, Path& path) noexcept {
  const auto of_frames = [&](const PointMeasurement& p) { return p.camera == rig_.frame_camera; };
  const bool has_frames = std::any_of(frame.points.begin(), frame.points.end(), of_frames);
  const std::uint8_t camera = has_frames ? rig_.frame_camera : rig_.event_camera;
  const Pose& T_body_cam = rig_.cameras[camera].T_body_cam;
  for (std::size_t back = times.size() - 1; back > 0; --back) {
    const std::size_t n = pairs_back(frame, back, camera);
    if (n < kFewestPairs) continue;
    const auto R_then_now = imu.rotation(times[back], times[0], gyro_bias_radps);
    if (!R_then_now || !(times[0] > times[back])) continue;
    const Eigen::Quaterniond R_now_then_cam =
        T_body_cam.q.conjugate() * R_then_now->conjugate() * T_body_cam.q;
    const MotionEstimate motion =
        checks_[camera].judge(R_now_then_cam.toRotationMatrix(), std::span(pairs_).first(n),
                              std::span(verdicts_).first(n));
    const double span_s = (times[0] - times[back]).seconds();
    EpipolarFit fit;
    if (motion.translating)
      fit = fit_epipolar(R_now_then_cam.toRotationMatrix(), std::span(pairs_).first(n),
                         motion.direction, mean_focal_px(rig_.cameras[camera]),
                         kGyroBias_radps * span_s);
    const Eigen::Vector3d step = motion.translating ? Eigen::Vector3d(T_body_cam.q * fit.direction)
                                                    : Eigen::Vector3d::Zero();
    const Eigen::Vector3d missed_radps = T_body_cam.q * fit.turn_rad / span_s;
    for (std::size_t k = 0; k <= back; ++k) {
      Eigen::Quaterniond R_now_k = Eigen::Quaterniond::Identity();
      if (k > 0) {
        const auto R = imu.rotation(times[k], times[0], gyro_bias_radps);
        if (!R) return 0;
        R_now_k = so3::exp(missed_radps * (times[0] - times[k]).seconds()) * R->conjugate();
      }
      // The camera's centre moves straight on; the body's is behind it by the lever arm.
      const double s = kGuessedSpeed_mps * (times[0] - times[k]).seconds();
      path[k] = {R_now_k, T_body_cam.p + s * step - R_now_k * T_body_cam.p};
    }
    return back + 1;
  }
  return 0;
}

/// Where a point is seen in the event camera: its bearing turned exactly, moved by the baseline
/// where its depth in metres is known, else as if it were infinitely far.
void TemporalCues::read_map(const FrameMeasurement& frame, const EventStage& events) noexcept {
  const Pose T_event_body = rig_.cameras[rig_.event_camera].T_body_cam.inverse();
  for (std::size_t i = 0; i < frame.points.size(); ++i) {
    const PointMeasurement& p = frame.points[i];
    const Pose T = T_event_body * rig_.cameras[p.camera].T_body_cam;
    Eigen::Vector3d ray = T.q * Eigen::Vector3d(p.bearing_xy[0], p.bearing_xy[1], 1.0);
    if (evidence_[i].depth_known) ray += evidence_[i].inverse_depth_pm * T.p;
    const std::optional<PixelScore> score =
        events.score(ray, ScorePooling::kPixel, ScoreForm::kPaper);
    if (!score) continue;
    weights_[i].paper = temporal_reliability(*score);
    weights_[i].count = event_count_reliability(score->n);
  }
}

}  // namespace pled
