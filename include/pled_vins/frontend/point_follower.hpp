#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "pled_vins/frontend/config.hpp"
#include "pled_vins/frontend/patch_aligner.hpp"
#include "pled_vins/frontend/point_track.hpp"
#include "pled_vins/frontend/pyramid.hpp"
#include "pled_vins/frontend/reference_patches.hpp"
#include "pled_vins/geometry/camera.hpp"

namespace pled {

/// Two frames and what is known of the motion between them.
struct FramePair {
  const Pyramid* previous = nullptr;
  const Pyramid* current = nullptr;
  Eigen::Matrix3d R_prev_cur = Eigen::Matrix3d::Identity();  ///< current camera to previous
  double dt_s = 0.0;
};

/// Finds one point of the previous frame in the current one: starts where the rotation takes it,
/// lens included, with the patch turned alike; refines from coarse to fine; checks the way back;
/// and aligns with the track's first view, so that the errors of the steps do not add up.
class PointFollower {
 public:
  /// @param reference_memory  ReferencePatches::kValues, outlives this object
  /// @param kind  kEventPoint: a lost patch is looked for once more with polarities exchanged
  PointFollower(const FrontendConfig& config, const Camera& camera,
                std::span<std::int16_t> reference_memory,
                FeatureKind kind = FeatureKind::kImagePoint) noexcept;

  /// Gives a new track at track.px a first view. False when there is no room.
  [[nodiscard]] bool begin(const Pyramid& frame, PointTrack& track) noexcept;
  /// Takes the first view back.
  void end(const PointTrack& track) noexcept { references_.release(track.slot); }
  void end_all() noexcept { references_.release_all(); }

  /// Moves the track into the current frame: px, bearing, rates, length. False when it is lost;
  /// the track is then as it was.
  [[nodiscard]] bool follow(const FramePair& frames, PointTrack& track) noexcept;

 private:
  /// Where a point should be in the new frame.
  struct Prediction {
    Eigen::Vector2d px;          ///< by the rotation alone
    Eigen::Matrix2d A_prev_cur;  ///< offsets in the new frame to offsets in the previous one
  };

  [[nodiscard]] bool find(const FramePair& frames, const PointTrack& track,
                          const Prediction& prediction, Eigen::Vector2d& px) noexcept;
  [[nodiscard]] std::optional<Prediction> predict(const FramePair& frames,
                                                  const PointTrack& track) const noexcept;
  [[nodiscard]] Eigen::Vector2d choose_start(const FramePair& frames, const PointTrack& track,
                                             const Prediction& prediction) noexcept;
  [[nodiscard]] bool align_levels(const FramePair& frames, const PointTrack& track,
                                  const Prediction& prediction, Eigen::Vector2d& px) noexcept;
  [[nodiscard]] bool returns(const FramePair& frames, const PointTrack& track,
                             const Prediction& prediction, const Eigen::Vector2d& px) noexcept;
  [[nodiscard]] bool unsettled(const PointTrack& track) const noexcept;
  void align_with_first_view(const Pyramid& frame, PointTrack& track, Eigen::Vector2d& px) noexcept;

  FrontendConfig config_;
  Camera camera_;
  PatchAligner aligner_;
  ReferencePatches references_;
  bool on_events_;
};

}  // namespace pled
