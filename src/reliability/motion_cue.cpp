#include "pled_vins/reliability/motion_cue.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "pled_vins/core/check.hpp"
#include "src/reliability/cue_pool.hpp"

namespace pled {
namespace {

using cue::kLeastZ;

/// One earlier sight of a point: q = a + rho t is its direction there, x where it was seen.
struct Sight {
  Eigen::Vector3d a;
  Eigen::Vector3d t;
  Eigen::Vector2d x;
};

struct DepthFit {
  double rho = 0.0;      ///< inverse depth
  double squares = 0.0;  ///< left over, bearing units
  double sigma = 0.0;    ///< of rho, for sights with unit noise in bearing units
};

/// Inverse depth in [0, kMaxInverseDepth] that brings a + rho t closest to the sights. Each step
/// solves the linear problem with the last step's z.
DepthFit best_inverse_depth(std::span<const Sight> sights) noexcept {
  DepthFit fit;
  for (int step = 0; step < cue::kFitSteps; ++step) {
    double h = 1e-12;
    double g = 0.0;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Sight& s : sights) {
      const double z = std::max(s.a.z() + fit.rho * s.t.z(), kLeastZ);
      const Eigen::Vector2d c = (s.t.head<2>() - s.x * s.t.z()) / z;
      const Eigen::Vector2d r = (s.a.head<2>() - s.x * s.a.z()) / z;
      h += c.squaredNorm();
      g -= c.dot(r);
      sum += c;
    }
    fit.rho = std::clamp(g / h, 0.0, cue::kMaxInverseDepth);
    // The newest sight's noise is in every difference: covariance I + 1 1^T.
    fit.sigma = std::sqrt(h + sum.squaredNorm()) / h;
  }
  for (const Sight& s : sights) {
    const Eigen::Vector3d q = s.a + fit.rho * s.t;
    fit.squares += (q.head<2>() / std::max(q.z(), kLeastZ) - s.x).squaredNorm();
  }
  return fit;
}

/// What is known of the points of one frame while they are pooled.
struct Pool {
  std::size_t n = 0;
  std::array<Eigen::Vector2d, limits::kMaxPoints> place;  ///< in the frame camera, plane z = 1
  std::array<double, limits::kMaxPoints> belief{};        ///< above 0: moves by itself
  std::array<double, limits::kMaxPoints> share{};         ///< of a say; 0 without evidence
};

/// Adds to each belief how much nearer the point is than what surrounds it, as far as depths are
/// known: a camera that hovers knows none.
void add_nearness(std::span<const MotionEvidence> evidence, Pool& pool) noexcept {
  std::array<cue::Nearness, limits::kMaxPoints> nearness{};
  std::array<double, limits::kMaxPoints> weights{};
  std::array<double, limits::kMaxPoints> sums{};
  for (std::size_t i = 0; i < pool.n; ++i) {
    if (evidence[i].frames == 0) continue;
    nearness[i] =
        cue::nearness_of(evidence[i].inverse_depth_pm, evidence[i].inverse_depth_sigma_pm);
    for (std::size_t k = 0; k < i; ++k) {
      if (evidence[k].frames == 0) continue;
      const double near =
          cue::closeness((pool.place[i] - pool.place[k]).squaredNorm(), cue::kNearnessRadius);
      weights[i] += nearness[k].sure * near;
      weights[k] += nearness[i].sure * near;
      sums[i] += nearness[k].sure * near * nearness[k].log_rho;
      sums[k] += nearness[i].sure * near * nearness[i].log_rho;
    }
  }
  for (std::size_t i = 0; i < pool.n; ++i)
    if (weights[i] > cue::kLeastWeight)
      pool.belief[i] += cue::doubt_of_near(nearness[i], sums[i] / weights[i]);
}

}  // namespace

MotionCue::MotionCue(const MotionCueConfig& config, const RigCalibration& rig) noexcept
    : config_(config), rig_(rig) {
  PLED_CHECK(check(config).key == nullptr);
}

const MotionCue::PastFrame& MotionCue::past(std::size_t back) const noexcept {
  return past_[(newest_ + limits::kCueFrames - back) % limits::kCueFrames];
}

FixedVector<Timestamp, limits::kCueFrames + 1> MotionCue::times(Timestamp t_now) const noexcept {
  FixedVector<Timestamp, limits::kCueFrames + 1> out;
  PLED_CHECK(out.push_back(t_now));
  for (std::size_t back = 0; back < num_past_; ++back) PLED_CHECK(out.push_back(past(back).t));
  return out;
}

std::optional<Eigen::Vector2d> MotionCue::bearing(FeatureId id, std::size_t back,
                                                  std::size_t hint) const noexcept {
  if (back >= num_past_) return std::nullopt;
  const PastFrame& frame = past(back);
  const std::optional<std::size_t> at = cue::find({frame.ids.data(), frame.ids.size()}, id, hint);
  if (!at) return std::nullopt;
  return Eigen::Vector2d(frame.bearings[*at][0], frame.bearings[*at][1]);
}

void MotionCue::reset() noexcept { num_past_ = 0; }

void MotionCue::judge(const FrameMeasurement& frame, std::span<const Pose> T_world_body,
                      bool metric, std::span<MotionEvidence> out) noexcept {
  PLED_CHECK(out.size() >= frame.points.size());
  for (std::size_t i = 0; i < frame.points.size(); ++i) {
    out[i] = {};
    fit_depth(frame.points[i], i, T_world_body, out[i]);
    out[i].depth_known =
        metric && out[i].inverse_depth_sigma_pm < cue::kWellKnown * out[i].inverse_depth_pm;
  }
  pool(frame, out);
  keep(frame);
}

void MotionCue::fit_depth(const PointMeasurement& point, std::size_t index,
                          std::span<const Pose> T_world_body, MotionEvidence& out) const noexcept {
  if (T_world_body.size() < 2) return;
  const CameraCalibration& camera = rig_.cameras[point.camera];
  const Pose T_world_now = T_world_body[0] * camera.T_body_cam;
  const Eigen::Vector3d ray(point.bearing_xy[0], point.bearing_xy[1], 1.0);
  std::array<Sight, limits::kCueFrames> sights;
  std::size_t n = 0;
  const std::size_t known = std::min(num_past_, T_world_body.size() - 1);
  std::size_t hint = index;
  for (std::size_t back = 0; back < known; ++back) {
    const PastFrame& frame = past(back);
    const std::optional<std::size_t> at =
        cue::find({frame.ids.data(), frame.ids.size()}, point.id, hint);
    if (!at) break;  // a track has no holes
    hint = *at;
    const Pose T_then_now = (T_world_body[back + 1] * camera.T_body_cam).inverse() * T_world_now;
    const auto& seen = frame.bearings[*at];
    sights[n++] = {T_then_now.q * ray, T_then_now.p, {seen[0], seen[1]}};
  }
  if (n == 0) return;
  const DepthFit fit = best_inverse_depth(std::span(sights).first(n));
  if (!std::isfinite(fit.squares) || !std::isfinite(fit.sigma)) return;
  const double focal_px = mean_focal_px(camera);
  const bool of_events = point.kind == FeatureKind::kEventPoint;
  const double noise_px = cue::kNoiseOfEven * (of_events ? config_.event_even_px : config_.even_px);
  out.inverse_depth_pm = fit.rho;
  out.inverse_depth_sigma_pm = noise_px / focal_px * fit.sigma;
  out.residual_px = focal_px * std::sqrt(fit.squares / static_cast<double>(n));
  out.frames = static_cast<std::uint8_t>(n);
}

void MotionCue::pool(const FrameMeasurement& frame, std::span<MotionEvidence> out) const noexcept {
  Pool pool;
  pool.n = frame.points.size();
  const Pose T_cam_body = rig_.cameras[rig_.frame_camera].T_body_cam.inverse();
  for (std::size_t i = 0; i < pool.n; ++i) {
    const PointMeasurement& p = frame.points[i];
    const Pose T = T_cam_body * rig_.cameras[p.camera].T_body_cam;
    pool.place[i] =
        cue::place_of(T, p.bearing_xy, out[i].depth_known ? out[i].inverse_depth_pm : 0.0);
    if (out[i].frames == 0) continue;
    const bool of_events = p.kind == FeatureKind::kEventPoint;
    pool.belief[i] =
        cue::belief_of(out[i].residual_px, of_events ? config_.event_even_px : config_.even_px);
    pool.share[i] = of_events ? config_.event_weight : 1.0;
  }
  add_nearness(out, pool);
  for (std::size_t i = 0; i < pool.n; ++i) {
    if (out[i].frames > 0) out[i].belief = pool.belief[i];
    double weights = 0.0;
    double sum = 0.0;
    for (std::size_t k = 0; k < pool.n; ++k) {
      if (out[k].frames == 0) continue;
      const double near = k == i ? config_.own_weight
                                 : cue::closeness((pool.place[i] - pool.place[k]).squaredNorm(),
                                                  config_.pool_radius);
      const double w = pool.share[k] * near;
      weights += w;
      sum += w * pool.belief[k];
    }
    if (!(weights > cue::kLeastWeight)) continue;
    out[i].w_static = cue::rest_of(sum / (weights + cue::kDoubt), config_.steepness);
  }
}

void MotionCue::keep(const FrameMeasurement& frame) noexcept {
  newest_ = (newest_ + 1) % limits::kCueFrames;
  num_past_ = std::min(num_past_ + 1, limits::kCueFrames);
  PastFrame& kept = past_[newest_];
  kept.t = frame.t;
  kept.ids.clear();
  for (std::size_t i = 0; i < frame.points.size(); ++i) {
    PLED_CHECK(kept.ids.push_back(frame.points[i].id));
    kept.bearings[i] = frame.points[i].bearing_xy;
  }
}

}  // namespace pled
