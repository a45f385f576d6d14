#pragma once

#include <array>
#include <optional>
#include <span>

#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/frontend/motion_check.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/imu/imu_history.hpp"
#include "pled_vins/imu/preintegration.hpp"
#include "pled_vins/pipeline/event_stage.hpp"
#include "pled_vins/pipeline/line_cues.hpp"
#include "pled_vins/pipeline/temporal_weights.hpp"
#include "pled_vins/reliability/motion_cue.hpp"

namespace pled {

/// Temporal reliability of the points and lines of each frame.
class TemporalCues {
 public:
  /// @param read_map  also paper and count, from the event stage's map
  TemporalCues(const MotionCueConfig& config, const RigCalibration& rig, bool read_map) noexcept;

  /// Weights for the points of `frame`, in its order; valid until the next call.
  /// @param known   the estimator's newest state before this frame; nullopt: not tracking. Then
  ///        the camera is taken to have moved straight on in the direction that most points agree
  ///        with, and to have turned as the gyro says: how fast does not matter to the misfit
  /// @param events  null without events
  [[nodiscard]] std::span<const TemporalWeights> judge(const FrameMeasurement& frame,
                                                       const ImuHistory& imu,
                                                       const std::optional<NavState>& known,
                                                       const Eigen::Vector3d& gyro_bias_radps,
                                                       const EventStage* events) noexcept;
  /// The same for its lines, after judge().
  [[nodiscard]] std::span<const TemporalWeights> lines() const noexcept { return lines_.weights(); }
  /// Gives each feature of the frame that judge() was last called for what the back end is to know:
  /// its w_temporal by this score, and lines their alpha_line, kPaper: to the letter.
  void write(TemporalScore score, FrameMeasurement& frame) const noexcept;

  void reset() noexcept;

 private:
  using Path = std::array<Pose, limits::kCueFrames + 1>;

  [[nodiscard]] std::size_t guess_path(const FrameMeasurement& frame,
                                       std::span<const Timestamp> times, const ImuHistory& imu,
                                       const Eigen::Vector3d& gyro_bias_radps, Path& path) noexcept;
  [[nodiscard]] std::size_t pairs_back(const FrameMeasurement& frame, std::size_t back,
                                       std::uint8_t camera) noexcept;
  void read_map(const FrameMeasurement& frame, const EventStage& events) noexcept;

  RigCalibration rig_;
  bool read_map_;
  MotionCue motion_;
  LineCues lines_;
  std::array<MotionCheck, limits::kMaxCameras> checks_;  ///< by camera
  std::array<BearingPair, limits::kMaxPoints> pairs_{};
  std::array<MotionVerdict, limits::kMaxPoints> verdicts_{};
  std::array<MotionEvidence, limits::kMaxPoints> evidence_{};
  std::array<TemporalWeights, limits::kMaxPoints> weights_{};
};

}  // namespace pled
