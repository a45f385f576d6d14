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
#include "pled_vins/reliability/motion_cue.hpp"

namespace pled {

/// What the motion cue found about one line.
struct LineMotionEvidence {
  /// 1: moves with the scene, 0: by itself. kNoEvidence when nobody near it knows, nor it itself.
  double w_static = kNoEvidence;
  /// Of the line alone: root of the sum of squared distances (pixels of its camera) between ends
  /// seen and the best line at rest, over `freedoms`. kNoEvidence with less than one.
  double residual_px = kNoEvidence;
  /// 1/m, >= 0: of the ends seen now on that line; kNoEvidence without an earlier sight.
  std::array<double, 2> inverse_depth_pm{kNoEvidence, kNoEvidence};
  /// What noise of the sights leaves open of the middle's, one sigma.
  double inverse_depth_sigma_pm = kNoEvidence;
  /// Two for each earlier sight, less what the free depths can explain: 2 when the camera moves
  /// across the line, 0 when in its plane or not at all.
  double freedoms = 0.0;
  bool depth_known = false;  ///< in metres, and to a third
  std::uint8_t frames = 0;   ///< earlier sights behind it
};

/// Tells lines that move by themselves from those at rest, before any bundle adjustment: MotionCue
/// for lines. Ours; it takes the place of the paper's z_line, which is kept as mode `paper`.
///
/// A line through the two ends seen now has two unknowns, their inverse depths. Each earlier sight
/// gives two distances of its ends. So it takes three sights to find fault with a line, or two when
/// the camera's way leaves the depths no say.
///
/// What a line alone can tell is little: where it moves steadily across itself while the camera
/// moves steadily, some other depth explains all of it, unless that depth would be negative or
/// nearer than 0.2 m; along itself nothing is seen at all. Hence a line that leaves nothing is
/// believed at rest only as far as its depths had no say, and points beside it, which see both
/// directions, do most of the telling, as do lines beside it. Of a line that is new they are all.
/// Then, as with points, what stands out towards the camera is doubted.
///
/// No allocation, no clock; one thread.
class LineMotionCue {
 public:
  /// @param config  of the points' cue, valid: check(config).key == nullptr
  LineMotionCue(const MotionCueConfig& config, const RigCalibration& rig) noexcept;

  /// The ends (plane z = 1) of a line in a kept frame: 0 the last one, 1 the one before, ...;
  /// nullopt when it was not seen. `hint`: its index in a neighbouring frame.
  [[nodiscard]] std::optional<std::array<Eigen::Vector2d, 2>> ends(FeatureId id, std::size_t back,
                                                                   std::size_t hint) const noexcept;

  /// Evidence for each line of `frame`; then keeps the frame for later ones. To be called for the
  /// same frames as MotionCue::judge().
  /// @param T_world_body  as given to MotionCue::judge(): of this frame first, then of those kept
  /// @param metric  false: those poses are right up to scale only
  /// @param points  what MotionCue::judge() found, one per point of `frame`
  /// @param out  as many as frame.lines
  /// Cost: n x 6 fits of 4 steps, and n (n + points) exponentials.
  void judge(const FrameMeasurement& frame, std::span<const Pose> T_world_body, bool metric,
             std::span<const MotionEvidence> points, std::span<LineMotionEvidence> out) noexcept;

  /// Forgets all frames.
  void reset() noexcept;

 private:
  struct PastFrame {
    FixedVector<FeatureId, limits::kMaxLines> ids;
    std::array<std::array<std::array<double, 2>, 2>, limits::kMaxLines> ends{};
  };

  void fit(const LineMeasurement& line, std::size_t index, std::span<const Pose> T_world_body,
           bool metric, LineMotionEvidence& out) const noexcept;
  void pool(const FrameMeasurement& frame, std::span<const MotionEvidence> points,
            std::span<LineMotionEvidence> out) const noexcept;
  void keep(const FrameMeasurement& frame) noexcept;
  [[nodiscard]] const PastFrame& past(std::size_t back) const noexcept;
  [[nodiscard]] double even_px(const LineMeasurement& line) const noexcept;

  MotionCueConfig config_;
  RigCalibration rig_;
  std::array<PastFrame, limits::kCueFrames> past_{};
  std::size_t newest_ = 0;  ///< index of the last frame kept
  std::size_t num_past_ = 0;
};

}  // namespace pled
