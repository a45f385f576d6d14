#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include <Eigen/Geometry>

#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/pipeline/event_stage.hpp"
#include "pled_vins/pipeline/temporal_weights.hpp"
#include "pled_vins/reliability/line_alpha.hpp"
#include "pled_vins/reliability/line_motion_cue.hpp"
#include "pled_vins/reliability/motion_cue.hpp"

namespace pled {

/// Temporal reliability of the lines of each frame; what TemporalCues does for points.
class LineCues {
 public:
  LineCues(const MotionCueConfig& config, const RigCalibration& rig) noexcept;

  /// The motion score of each line of `frame`; parameters as of LineMotionCue::judge. To be called
  /// for every frame, after the points were judged.
  void judge(const FrameMeasurement& frame, std::span<const Pose> T_world_body, bool metric,
             std::span<const MotionEvidence> points) noexcept;

  /// Then the scores of the map, and alpha_line where the line was in the last frame too.
  ///   paper  z_line over all pixels of the band; kNoEvidence without a single event in it, as of
  ///          points. Differs: by the letter it would be 1.
  ///   count  mean over the band's pixels that have events
  /// @param points_motion  has the same frame as its newest; `points` is its evidence
  /// @param R_last_now_body  body now to body at the last frame; nullopt: unknown, and so alpha is
  void read_map(const FrameMeasurement& frame, const MotionCue& points_motion,
                std::span<const MotionEvidence> points,
                const std::optional<Eigen::Quaterniond>& R_last_now_body,
                const EventStage& events) noexcept;

  /// One per line of the frame judged last.
  [[nodiscard]] std::span<const TemporalWeights> weights() const noexcept {
    return std::span(weights_).first(size_);
  }
  /// alpha_line of eq. (15), kPaper: to the letter, else with its pitfalls taken care of; NaN:
  /// unknown.
  [[nodiscard]] double alpha(std::size_t line, TemporalScore score) const noexcept {
    return score == TemporalScore::kPaper ? alphas_[line].paper : alphas_[line].clean;
  }

  void reset() noexcept;

 private:
  struct Alphas {
    double paper = kNoEvidence;
    double clean = kNoEvidence;
  };
  class MapView;

  void read_line(const LineMeasurement& line, std::size_t index, const MapView& view,
                 std::span<const PointMotion> points) noexcept;

  RigCalibration rig_;
  LineMotionCue motion_;
  std::size_t size_ = 0;
  std::array<LineMotionEvidence, limits::kMaxLines> evidence_{};
  std::array<TemporalWeights, limits::kMaxLines> weights_{};
  std::array<Alphas, limits::kMaxLines> alphas_{};
};

}  // namespace pled
