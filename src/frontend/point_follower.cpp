#include "pled_vins/frontend/point_follower.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace pled {
namespace {

constexpr double kBorderPx = 3.0;      ///< a track nearer to the edge than this ends
constexpr double kTolerancePx = 0.01;  ///< convergence at full resolution
constexpr double kCoarseTolerancePx = 0.05;
constexpr float kMinSimilarity = 0.75F;  ///< frame to frame
constexpr float kMinFirstViewSimilarity = 0.8F;
/// Ours: drift of a track between two alignments with its first view stays well below this.
constexpr double kMaxFirstViewStepPx = 0.8;
/// Smaller eigenvalue of the structure tensor below which noise decides, (grey/px)^2.
constexpr float kMinTexture = 0.4F;
constexpr float kMinCoarseTexture = 0.1F;
/// Outside these scales a first view no longer resembles the surface.
constexpr double kMinScale = 0.6;
constexpr double kMaxScale = 1.6;

[[nodiscard]] PatchSource level_of(const Pyramid& pyramid, int level) noexcept {
  return PatchSource::whole(pyramid.levels[static_cast<std::size_t>(level)]);
}

[[nodiscard]] bool sound_scale(const Eigen::Matrix2d& A) noexcept {
  const double scale = std::sqrt(std::max(0.0, A.determinant()));
  return scale > kMinScale && scale < kMaxScale && A.norm() < 2.0 * kMaxScale;
}

}  // namespace

PointFollower::PointFollower(const FrontendConfig& config, const Camera& camera,
                             std::span<std::int16_t> reference_memory, FeatureKind kind) noexcept
    : config_(config),
      camera_(camera),
      aligner_(config.patch_radius_px),
      references_(reference_memory),
      on_events_(kind == FeatureKind::kEventPoint) {}

/// Around a new corner events have drawn one side only; a first view is worth keeping later.
bool PointFollower::unsettled(const PointTrack& track) const noexcept {
  return on_events_ && track.length < kSettledSights;
}

bool PointFollower::begin(const Pyramid& frame, PointTrack& track) noexcept {
  const std::optional<ReferencePatches::Slot> slot = references_.acquire();
  if (!slot) return false;
  track.slot = *slot;
  track.A_reference.setIdentity();
  references_.store(track.slot, frame.levels[0], track.px);
  return true;
}

bool PointFollower::follow(const FramePair& frames, PointTrack& track) noexcept {
  const std::optional<Prediction> prediction = predict(frames, track);
  if (!prediction || !camera_.inside(prediction->px)) return false;
  Eigen::Vector2d px;
  bool inverted = false;
  if (!find(frames, track, *prediction, px)) {
    if (!on_events_) return false;
    aligner_.set_inverted(true);
    inverted = find(frames, track, *prediction, px);
    aligner_.set_inverted(false);
    if (!inverted) return false;
  }

  const Eigen::Matrix2d A_before = track.A_reference;
  track.A_reference = A_before * prediction->A_prev_cur;
  if (inverted || unsettled(track)) {  // the first view has the other polarity, or is half drawn
    references_.store(track.slot, frames.current->levels[0], px);
    track.A_reference.setIdentity();
  } else {
    align_with_first_view(*frames.current, track, px);
  }
  const std::optional<Eigen::Vector2d> bearing =
      camera_.inside(px, kBorderPx) ? camera_.undistort(px) : std::nullopt;
  if (!bearing) {
    track.A_reference = A_before;
    return false;
  }
  track.flow_px = (px - track.px).norm();
  track.parallax_px = px - prediction->px;
  const double rate = frames.dt_s > 0.0 ? 1.0 / frames.dt_s : 0.0;
  track.parallax_pxps = track.parallax_px * rate;
  track.bearing_rate_ps = (*bearing - track.bearing) * rate;
  track.px = px;
  track.bearing = *bearing;
  ++track.length;
  return true;
}

bool PointFollower::find(const FramePair& frames, const PointTrack& track,
                         const Prediction& prediction, Eigen::Vector2d& px) noexcept {
  px = choose_start(frames, track, prediction);
  return align_levels(frames, track, prediction, px) && camera_.inside(px, kBorderPx) &&
         returns(frames, track, prediction, px);
}

std::optional<PointFollower::Prediction> PointFollower::predict(
    const FramePair& frames, const PointTrack& track) const noexcept {
  const Eigen::Matrix3d& R = frames.R_prev_cur;
  const Eigen::Vector3d ray = R.transpose() * track.bearing.homogeneous();
  if (!(ray.z() > 0.1)) return std::nullopt;
  const std::optional<Eigen::Vector2d> px = camera_.project(ray);
  if (!px) return std::nullopt;
  // x_prev = distort(h(R (x_cur, 1))), h the division by z: chain of three 2x2 Jacobians.
  const Eigen::Vector2d bearing = ray.head<2>() / ray.z();
  Eigen::Matrix2d d_cur_d_xy, d_prev_d_xy;
  (void)camera_.distort(bearing, d_cur_d_xy);
  (void)camera_.distort(track.bearing, d_prev_d_xy);
  const Eigen::Vector3d back = R * bearing.homogeneous();
  Eigen::Matrix2d d_h;
  d_h.row(0) = (R.block<1, 2>(0, 0) - back.x() / back.z() * R.block<1, 2>(2, 0)) / back.z();
  d_h.row(1) = (R.block<1, 2>(1, 0) - back.y() / back.z() * R.block<1, 2>(2, 0)) / back.z();
  const Prediction prediction{*px, d_prev_d_xy * d_h * d_cur_d_xy.inverse()};
  if (!prediction.A_prev_cur.allFinite()) return std::nullopt;
  return prediction;
}

/// Ours: a point that kept its parallax velocity is nearer to the truth than one without parallax,
/// but after a jolt it is not; the coarsest level tells which fits better.
Eigen::Vector2d PointFollower::choose_start(const FramePair& frames, const PointTrack& track,
                                            const Prediction& prediction) noexcept {
  const Eigen::Vector2d moved = prediction.px + track.parallax_pxps * frames.dt_s;
  if (!camera_.inside(moved) || (moved - prediction.px).squaredNorm() < 1.0) return prediction.px;
  const int level = std::min(1, frames.current->num_levels - 1);
  const double scale = 1.0 / (1 << level);
  const PatchSource target = level_of(*frames.current, level);
  if (!aligner_.set_template(level_of(*frames.previous, level), track.px * scale,
                             prediction.A_prev_cur, target, prediction.px * scale,
                             PatchModel::kShift, kMinCoarseTexture))
    return prediction.px;
  const float still = aligner_.similarity(target, prediction.px * scale);
  return aligner_.similarity(target, moved * scale) > still ? moved : prediction.px;
}

bool PointFollower::align_levels(const FramePair& frames, const PointTrack& track,
                                 const Prediction& prediction, Eigen::Vector2d& px) noexcept {
  for (int level = frames.current->num_levels - 1; level >= 0; --level) {
    const double scale = 1.0 / (1 << level);
    const PatchSource target = level_of(*frames.current, level);
    Eigen::Vector2d at = px * scale;
    if (!aligner_.set_template(level_of(*frames.previous, level), track.px * scale,
                               prediction.A_prev_cur, target, at, PatchModel::kShift,
                               level == 0 ? kMinTexture : kMinCoarseTexture)) {
      if (level == 0) return false;
      continue;
    }
    if (level == 0) {
      const AlignResult result = aligner_.align(target, config_.max_iterations, kTolerancePx, at);
      if (!result.ok || !(result.similarity > kMinSimilarity)) return false;
      px = at;
      return true;
    }
    // A coarse level may only help: its result counts when it fits better than the start.
    const AlignResult result =
        aligner_.align(target, config_.max_iterations, kCoarseTolerancePx, at);
    if (result.ok && result.similarity > result.start_similarity && camera_.inside(at / scale))
      px = at / scale;
  }
  return false;
}

bool PointFollower::returns(const FramePair& frames, const PointTrack& track,
                            const Prediction& prediction, const Eigen::Vector2d& px) noexcept {
  // From the prediction's error, not from the answer: the way back starts without parallax.
  const Eigen::Matrix2d A_cur_prev = prediction.A_prev_cur.inverse();
  const PatchSource target = level_of(*frames.previous, 0);
  Eigen::Vector2d back = track.px;
  if (!aligner_.set_template(level_of(*frames.current, 0), px, A_cur_prev, target, back,
                             PatchModel::kShift, kMinTexture))
    return false;
  const AlignResult result = aligner_.align(target, config_.max_iterations, kTolerancePx, back);
  return result.ok && (back - track.px).norm() < config_.forward_backward_px;
}

void PointFollower::align_with_first_view(const Pyramid& frame, PointTrack& track,
                                          Eigen::Vector2d& px) noexcept {
  const PatchSource target = level_of(frame, 0);
  Eigen::Vector2d at = px;
  if (sound_scale(track.A_reference) &&
      aligner_.set_template(references_.source(track.slot), references_.centre_px(track.slot),
                            track.A_reference, target, at,
                            on_events_ ? PatchModel::kShift : PatchModel::kAffine, kMinTexture)) {
    const AlignResult result = aligner_.align(target, config_.max_iterations, kTolerancePx, at);
    if (result.ok && result.similarity > kMinFirstViewSimilarity &&
        (at - px).norm() < kMaxFirstViewStepPx) {
      px = at;
      track.A_reference = track.A_reference * result.deformation;
      return;
    }
  }
  references_.store(track.slot, frame.levels[0], px);
  track.A_reference.setIdentity();
}

}  // namespace pled
