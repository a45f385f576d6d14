#include "pled_vins/pipeline/vio_pipeline.hpp"

#include <optional>

#include "pled_vins/geometry/so3.hpp"

namespace pled {

namespace {

// A sound rig starts within this; then the clocks are doubted, and again every half second.
constexpr Duration kTrustClocks = Duration::from_ms(2500);
constexpr Duration kSearchAgain = Duration::from_ms(500);

}  // namespace

VioPipeline::VioPipeline(const RigCalibration& rig, ImuHistory& imu, FrameTracker& tracker,
                         Backend& backend, Health& health, const PipelineOptions& options,
                         EventStage* events, LineStage* lines) noexcept
    : rig_(rig),
      imu_(imu),
      tracker_(tracker),
      backend_(backend),
      health_(health),
      frame_shift_(Duration::from_s(rig.cameras[rig.frame_camera].time_shift_s)),
      options_(options),
      events_(events),
      lines_(lines),
      cues_(options.motion_cue, rig, options.all_scores || options.score != TemporalScore::kMotion),
      find_time_shift_(options.find_time_shift) {}

void VioPipeline::on_imu(const ImuSample& sample) noexcept {
  ++health_.imu.in;
  if (imu_.add(sample)) {
    ++health_.imu.used;
  } else {
    ++health_.imu.dropped;
  }
  const ImuFaults& faults = imu_.faults();
  health_.set(Fault::kImuGap, faults.gaps);
  health_.set(Fault::kImuDuplicate, faults.duplicates);
  health_.set(Fault::kImuBackwards, faults.backwards);
  health_.set(Fault::kImuNotFinite, faults.not_finite);
  health_.set(Fault::kImuImplausible, faults.implausible);
}

void VioPipeline::on_clock_jump() noexcept {
  health_.count(Fault::kClockJump);
  imu_.forget_samples();
  has_last_frame_ = false;
  output_.has_pose = false;
  backend_.restart();
  tracker_.reset();
  cues_.reset();
  admission_.reset();
  time_shift_search_.reset();
  next_search_.reset();
  event_points_ = {};  // else new corners would keep away from where points were
  if (events_ != nullptr) events_->reset();
  if (lines_ != nullptr) lines_->reset();
}

Eigen::Vector3d VioPipeline::gyro_bias() const noexcept {
  if (!output_.has_pose) return still_bias_.gyro_bias_radps();
  return Eigen::Map<const Eigen::Vector3d>(output_.pose.gyro_bias_radps.data());
}

void VioPipeline::expect(const FrameView& frame) noexcept {
  if (events_ != nullptr) events_->expect(frame_time(frame));
}

Timestamp VioPipeline::last_event_time(const FrameView& frame) const noexcept {
  const Duration shift = events_ != nullptr
                             ? events_->time_shift()
                             : Duration::from_s(rig_.cameras[rig_.event_camera].time_shift_s);
  return frame_time(frame) - shift;
}

void VioPipeline::on_events(std::span<const Event> events) noexcept {
  health_.events.in += events.size();
  if (events_ == nullptr) return;
  events_->follow_turn(imu_, gyro_bias());
  events_->on_events(events);
}

Timestamp VioPipeline::frame_time(const FrameView& frame) const noexcept {
  return frame.t + frame_shift_;
}

bool VioPipeline::covered_by_imu(Timestamp t) const noexcept {
  const std::optional<Timestamp> oldest = imu_.oldest();
  const std::optional<Timestamp> newest = imu_.newest();
  if (!oldest || !newest) return false;
  const Duration slack = imu_.gap_threshold();
  return t >= *oldest - slack && t <= *newest + slack;
}

/// Why a frame cannot be used; kCount when it can.
Fault VioPipeline::refusal(const FrameView& frame, Timestamp t) const noexcept {
  const CameraCalibration& camera = rig_.cameras[rig_.frame_camera];
  if (has_last_frame_ && t <= last_frame_) return Fault::kFrameOutOfOrder;
  if (options_.use_frames &&
      (frame.image.width != camera.width_px || frame.image.height != camera.height_px))
    return Fault::kFrameWrongSize;
  if (!covered_by_imu(t)) return Fault::kFrameWithoutImu;
  return Fault::kCount;
}

bool VioPipeline::on_frame(const FrameView& frame, FrameResult& result) noexcept {
  ++health_.frames.in;
  const Timestamp t = frame_time(frame);
  const Fault why_not = refusal(frame, t);
  if (why_not != Fault::kCount) {
    health_.count(why_not);
    ++health_.frames.dropped;
    return false;
  }
  ++health_.frames.used;
  std::optional<Eigen::Quaterniond> R_prev_cur_body;
  if (has_last_frame_) R_prev_cur_body = imu_.rotation(last_frame_, t, gyro_bias());
  track(frame, t, R_prev_cur_body);
  if (lines_ != nullptr) find_lines(frame, R_prev_cur_body);
  weigh(result);
  {
    const StageTimer timer(health_, Stage::kBackend);
    backend_.process(measurement_, imu_, output_);
  }
  health_.set(Fault::kEstimatorReset, output_.pose.reset_counter);
  result.measurement = &measurement_;
  result.backend = &output_;
  result.pose_at_stamp = carried_back(output_.pose);
  const Timestamp before = last_frame_;
  last_frame_ = t;
  if (has_last_frame_) look_for_time_shift(before, t);
  has_last_frame_ = true;
  return true;
}

void VioPipeline::look_for_time_shift(Timestamp from, Timestamp to) noexcept {
  if (output_.has_pose) find_time_shift_ = false;  // what starts has sound clocks
  if (!find_time_shift_) return;
  time_shift_search_.observe(from, to, measurement_, seeing_camera());
  if (!next_search_) next_search_ = to + kTrustClocks;
  if (to < *next_search_) return;
  next_search_ = to + kSearchAgain;
  const std::optional<Duration> shift = time_shift_search_.find(imu_);
  if (!shift) return;
  health_.count(Fault::kTimeShiftCorrected);
  correct_clocks(*shift);
  cues_.reset();
  backend_.forget_frames();
  time_shift_search_.reset();
  next_search_ = last_frame_ + kTrustClocks;
}

std::uint8_t VioPipeline::seeing_camera() const noexcept {
  return options_.use_frames ? rig_.frame_camera : rig_.event_camera;
}

/// Cameras that the calibration tells apart have clocks of their own; one that is both has one.
void VioPipeline::correct_clocks(Duration shift) noexcept {
  const bool one_clock = rig_.frame_camera == rig_.event_camera;
  if (options_.use_frames || one_clock) {
    frame_shift_ = frame_shift_ + shift;
    last_frame_ = last_frame_ + shift;
    tracker_.shift_clock(shift);
    if (lines_ != nullptr) lines_->shift_frames(shift);
  }
  if (events_ == nullptr) return;
  if (options_.use_frames && !one_clock) {
    events_->shift_clock(shift);
    if (lines_ != nullptr) lines_->shift_events(shift);
    return;
  }
  events_->correct_clock(shift);
  if (lines_ != nullptr) lines_->reset_events();
  event_points_ = {};
}

PoseEstimate VioPipeline::carried_back(const PoseEstimate& pose) const noexcept {
  // Over the few milliseconds of a time shift, speed and turning rate are constant.
  const double shift_s = frame_shift_.seconds();
  if (shift_s == 0.0 || imu_.size() == 0) return pose;
  const Eigen::Map<const Eigen::Vector3d> gyro(imu_[imu_.size() - 1].gyro_radps.data());
  const Eigen::Map<const Eigen::Vector3d> bias(pose.gyro_bias_radps.data());
  PoseEstimate back = pose;
  back.t = pose.t - frame_shift_;
  for (std::size_t k = 0; k < 3; ++k) back.p_world_body_m[k] -= pose.v_world_body_mps[k] * shift_s;
  Eigen::Map<Eigen::Quaterniond> q(back.q_world_body_xyzw.data());
  const Eigen::Vector3d turned = -shift_s * (gyro - bias);
  q = (q * so3::exp(turned)).normalized();
  return back;
}

void VioPipeline::track(const FrameView& frame, Timestamp t,
                        const std::optional<Eigen::Quaterniond>& R_prev_cur_body) noexcept {
  const StageTimer timer(health_, Stage::kFrontend);
  if (options_.use_frames) {
    std::optional<Eigen::Quaterniond> R_prev_cur_cam;
    if (R_prev_cur_body) {
      const Eigen::Quaterniond& R_body_cam = rig_.cameras[rig_.frame_camera].T_body_cam.q;
      R_prev_cur_cam = R_body_cam.conjugate() * *R_prev_cur_body * R_body_cam;
    }
    tracker_.track(frame, t, R_prev_cur_cam, measurement_);
  } else {
    measurement_ = {};
    measurement_.t = t;
    measurement_.stamp_ns = frame.stamp_ns;
  }
  if (events_ != nullptr) add_event_points(t, R_prev_cur_body);
  if (has_last_frame_ && !output_.has_pose) {
    still_bias_.observe(imu_, last_frame_, t, measurement_.median_flow_px,
                        measurement_.points.size());
  }
}

void VioPipeline::add_event_points(
    Timestamp t, const std::optional<Eigen::Quaterniond>& R_prev_cur_body) noexcept {
  events_->follow_turn(imu_, gyro_bias());
  events_->observe(t, measurement_.stamp_ns, R_prev_cur_body, event_points_);
  for (const PointMeasurement& point : event_points_.points)
    if (!measurement_.points.push_back(point)) break;  // the settings leave room for all
  measurement_.lost += event_points_.lost;
  if (options_.use_frames) {
    admission_.decide(measurement_, output_.has_pose);
  } else {
    admit_settled(measurement_);
    measurement_.median_flow_px = event_points_.median_flow_px;
    measurement_.median_parallax_px = event_points_.median_parallax_px;
  }
  report_events();
}

void VioPipeline::find_lines(const FrameView& frame,
                             const std::optional<Eigen::Quaterniond>& R_prev_cur_body) noexcept {
  const StageTimer timer(health_, Stage::kLines);
  LinePictures pictures;
  if (options_.use_frames) pictures.frame = frame.image;
  if (events_ != nullptr) pictures.events = events_->line_picture();
  lines_->observe(pictures, R_prev_cur_body, measurement_);
  health_.set(Fault::kLinePictureSkipped, lines_->skipped());
}

void VioPipeline::report_events() noexcept {
  const EventStageCounts counts = events_->counts();
  const SurfaceCounts& surface = counts.surface;
  health_.set(Fault::kEventShed, counts.shed);
  health_.set(Fault::kEventHotPixel, surface.hot);
  health_.set(Fault::kEventStampWild, surface.strange_stamp);
  health_.set(Fault::kEventWithoutTurn, counts.still_pictures + counts.without_turn);
  health_.set(Fault::kEventMapFull, counts.map.saturated);
  health_.set(Fault::kEventMapLate, counts.map.late);
  health_.set(Fault::kEventMapOutside, counts.map.outside);
  health_.set(Fault::kEventTurnGap, counts.turn.gaps + counts.turn.restarts);
  health_.set(Fault::kEventTurnDropped, counts.turn.backwards + counts.turn.not_finite);
  health_.events.dropped = counts.shed + surface.hot + surface.outside + surface.strange_stamp;
  health_.events.used = health_.events.in - health_.events.dropped;
}

std::optional<NavState> VioPipeline::known_state() const noexcept {
  if (!output_.has_pose || !has_last_frame_) return std::nullopt;
  const PoseEstimate& pose = output_.pose;
  NavState x;
  x.t = pose.t;
  x.p_wb = Eigen::Map<const Eigen::Vector3d>(pose.p_world_body_m.data());
  x.q_wb = Eigen::Map<const Eigen::Quaterniond>(pose.q_world_body_xyzw.data());
  x.v_wb = Eigen::Map<const Eigen::Vector3d>(pose.v_world_body_mps.data());
  x.bg = Eigen::Map<const Eigen::Vector3d>(pose.gyro_bias_radps.data());
  x.ba = Eigen::Map<const Eigen::Vector3d>(pose.accel_bias_mps2.data());
  return x;
}

/// Before the bundle adjustment, with the state it gave for the last frame.
void VioPipeline::weigh(FrameResult& result) noexcept {
  const StageTimer timer(health_, Stage::kScores);
  result.temporal = cues_.judge(measurement_, imu_, known_state(), gyro_bias(), events_);
  result.temporal_lines = cues_.lines();
  cues_.write(options_.score, measurement_);
}

}  // namespace pled
