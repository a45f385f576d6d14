#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "pled_vins/backend/backend.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/frontend/frame_tracker.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/imu/imu_history.hpp"
#include "pled_vins/pipeline/event_admission.hpp"
#include "pled_vins/pipeline/event_stage.hpp"
#include "pled_vins/pipeline/health.hpp"
#include "pled_vins/pipeline/line_stage.hpp"
#include "pled_vins/pipeline/still_gyro_bias.hpp"
#include "pled_vins/pipeline/temporal_cues.hpp"
#include "pled_vins/pipeline/time_shift_search.hpp"

namespace pled {

/// What one frame led to. Valid until the next frame.
struct FrameResult {
  const FrameMeasurement* measurement = nullptr;
  const BackendOutput* backend = nullptr;
  /// The newest pose at the frame's stamp on the IMU's clock: the state at
  /// mid-exposure carried back by the time shift. Meaningless without has_pose.
  PoseEstimate pose_at_stamp;
  /// One per point of the measurement, in its order.
  std::span<const TemporalWeights> temporal;
  std::span<const TemporalWeights> temporal_lines;  ///< the same of lines
};

/// How a pipeline works.
struct PipelineOptions {
  /// Look for a gross offset of the clocks as long as no start succeeds.
  bool find_time_shift = true;
  /// False: frames give only the times of observations; all points come from events.
  bool use_frames = true;
  MotionCueConfig motion_cue;
  TemporalScore score = TemporalScore::kMotion;  ///< which one is given out as w_temporal
  bool all_scores = false;                       ///< the others too, in FrameResult::temporal
};

/// The stages joined in order: data goes in at the top, one result a frame comes
/// out. A plain object without threads; the caller brings data in time order.
class VioPipeline {
 public:
  /// Nothing is owned; all outlive the pipeline.
  /// @param events  null: events are counted and not looked at
  /// @param lines  null: no lines are looked for. Lines of events need an event stage that draws
  ///        them (EventStageConfig::line_picture)
  VioPipeline(const RigCalibration& rig, ImuHistory& imu, FrameTracker& tracker, Backend& backend,
              Health& health, const PipelineOptions& options = {}, EventStage* events = nullptr,
              LineStage* lines = nullptr) noexcept;

  /// One inertial sample, as it arrived. Bad ones are dropped and counted.
  void on_imu(const ImuSample& sample) noexcept;
  /// Says which frame is next, before its events come.
  void expect(const FrameView& frame) noexcept;
  /// Until when the events of a frame reach, on their own clock.
  [[nodiscard]] Timestamp last_event_time(const FrameView& frame) const noexcept;
  /// Events in time order, up to the next frame.
  void on_events(std::span<const Event> events) noexcept;
  /// One frame; inertial samples up to its time (and one beyond, where there is
  /// one) must have come before. False when the frame was dropped and counted.
  [[nodiscard]] bool on_frame(const FrameView& frame, FrameResult& result) noexcept;

  /// From here on another clock stamps everything: what was measured before cannot be joined.
  /// The estimator starts anew at the place it had.
  void on_clock_jump() noexcept;

  /// Mid-exposure of `frame` on the estimator clock.
  [[nodiscard]] Timestamp frame_time(const FrameView& frame) const noexcept;

  /// What is added to the frames' stamps: the calibrated timeshift_cam_imu and what was found on
  /// top of it (counted as Fault::kTimeShiftCorrected).
  [[nodiscard]] Duration frame_shift() const noexcept { return frame_shift_; }
  /// The same for the camera that is seen by: of the frames, or without them of the events.
  [[nodiscard]] Duration seeing_shift() const noexcept {
    return options_.use_frames || events_ == nullptr ? frame_shift_ : events_->time_shift();
  }

 private:
  [[nodiscard]] bool covered_by_imu(Timestamp t) const noexcept;
  [[nodiscard]] Fault refusal(const FrameView& frame, Timestamp t) const noexcept;
  void track(const FrameView& frame, Timestamp t,
             const std::optional<Eigen::Quaterniond>& R_prev_cur_body) noexcept;
  void add_event_points(Timestamp t,
                        const std::optional<Eigen::Quaterniond>& R_prev_cur_body) noexcept;
  void find_lines(const FrameView& frame,
                  const std::optional<Eigen::Quaterniond>& R_prev_cur_body) noexcept;
  void weigh(FrameResult& result) noexcept;
  void report_events() noexcept;
  [[nodiscard]] Eigen::Vector3d gyro_bias() const noexcept;
  [[nodiscard]] std::optional<NavState> known_state() const noexcept;
  [[nodiscard]] std::uint8_t seeing_camera() const noexcept;
  void correct_clocks(Duration shift) noexcept;
  void look_for_time_shift(Timestamp from, Timestamp to) noexcept;
  [[nodiscard]] PoseEstimate carried_back(const PoseEstimate& pose) const noexcept;

  const RigCalibration& rig_;
  ImuHistory& imu_;
  FrameTracker& tracker_;
  Backend& backend_;
  Health& health_;
  Duration frame_shift_;
  StillGyroBias still_bias_;
  TimeShiftSearch time_shift_search_;
  PipelineOptions options_;
  EventStage* events_;
  LineStage* lines_;
  EventAdmission admission_;
  TemporalCues cues_;
  bool find_time_shift_;  ///< until the first pose
  std::optional<Timestamp> next_search_;
  FrameMeasurement measurement_;
  FrameMeasurement event_points_;
  BackendOutput output_;
  bool has_last_frame_ = false;
  Timestamp last_frame_;
};

}  // namespace pled
