#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/reliability/motion_config.hpp"

namespace pled {

/// What the motion cue found about one point.
struct MotionEvidence {
  /// 1: moves with the scene, 0: by itself. kNoEvidence when neither the point nor any near it has
  /// been seen in an earlier frame.
  double w_static = kNoEvidence;
  /// Of the point alone: root of the mean square distance (pixels of its camera) between where it
  /// was seen and where one point at rest, at the depth that suits best, would have been.
  /// kNoEvidence for a point not seen before.
  double residual_px = kNoEvidence;
  double inverse_depth_pm = kNoEvidence;  ///< that depth, 1/m, >= 0; with residual_px
  /// What noise of the sights leaves open of it, one sigma; with residual_px.
  double inverse_depth_sigma_pm = kNoEvidence;
  bool depth_known = false;  ///< in metres, and to a third
  std::uint8_t frames = 0;   ///< earlier frames behind it
  /// Of the point alone, its residual and how near it stands: above 0 moves, in units of
  /// log(residual / even_px); with residual_px.
  double belief = kNoEvidence;
};

/// Tells points that move by themselves from those at rest, by their tracks of the last few tenths
/// of a second, before any bundle adjustment. Ours; it takes the place of the paper's
/// entropy-recency score, which is kept as mode `paper`.
///
/// A point at rest, seen from known camera poses, may only lie on the epipolar segments that
/// positive depth allows. Each track is fitted with its best depth and judged by what is left over.
/// As objects are larger than points, what neighbours found speaks too, with a weight that falls
/// with the distance in the picture; so a point seen for the first time has evidence as well. Event
/// and image points speak for each other.
///
/// Last, what stands out towards the camera from its surroundings is doubted a little: cars and
/// people do, and one that comes straight towards a moving camera looks nearer still than it is,
/// though its residual is none.
///
/// Without that, unseen would be what moves along its epipolar lines as another depth
/// would. Still unseen is such a thing that looks farther than it is (a car ahead that drives
/// away), and what hardly moves in the picture.
///
/// No allocation, no clock; one thread.
class MotionCue {
 public:
  /// @param config  valid: check(config).key == nullptr
  MotionCue(const MotionCueConfig& config, const RigCalibration& rig) noexcept;

  /// Times of the frames whose body poses judge() can use: the frame that is coming at `t_now`
  /// first, then earlier ones, newest first.
  [[nodiscard]] FixedVector<Timestamp, limits::kCueFrames + 1> times(
      Timestamp t_now) const noexcept;

  /// Where a point was seen in a kept frame: 0 the last one, 1 the one before, ...; nullopt when it
  /// was not. `hint`: its index in a neighbouring frame.
  [[nodiscard]] std::optional<Eigen::Vector2d> bearing(FeatureId id, std::size_t back,
                                                       std::size_t hint) const noexcept;

  /// Evidence for each point of `frame`; then keeps the frame for later ones.
  /// @param T_world_body  poses at times(frame.t), or fewer: then only those frames count. Empty:
  ///        nothing is known, and no point gets evidence
  /// @param metric  false: those poses are right up to scale only
  /// @param out  as many as frame.points
  void judge(const FrameMeasurement& frame, std::span<const Pose> T_world_body, bool metric,
             std::span<MotionEvidence> out) noexcept;

  /// Forgets all frames.
  void reset() noexcept;

 private:
  struct PastFrame {
    Timestamp t;
    FixedVector<FeatureId, limits::kMaxPoints> ids;
    std::array<std::array<double, 2>, limits::kMaxPoints> bearings{};
  };

  void fit_depth(const PointMeasurement& point, std::size_t index,
                 std::span<const Pose> T_world_body, MotionEvidence& out) const noexcept;
  void pool(const FrameMeasurement& frame, std::span<MotionEvidence> out) const noexcept;
  void keep(const FrameMeasurement& frame) noexcept;
  [[nodiscard]] const PastFrame& past(std::size_t back) const noexcept;

  MotionCueConfig config_;
  RigCalibration rig_;
  std::array<PastFrame, limits::kCueFrames> past_{};
  std::size_t newest_ = 0;  ///< index of the last frame kept
  std::size_t num_past_ = 0;
};

}  // namespace pled
