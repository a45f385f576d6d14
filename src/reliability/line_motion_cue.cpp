#include "pled_vins/reliability/line_motion_cue.hpp"

#include <algorithm>
#include <cmath>

#include "pled_vins/core/check.hpp"
#include "src/reliability/cue_pool.hpp"
#include "src/reliability/line_depths.hpp"

namespace pled {
namespace {

/// Less evidence than one distance is none.
constexpr double kLeastFreedoms = 1.0;
/// How much of a line's own word is left when it leaves nothing but both depths were free.
constexpr double kWordOfFree = 0.25;

/// A segment on the plane z = 1 of the frame camera.
struct Place {
  Eigen::Vector2d start;
  Eigen::Vector2d end;

  [[nodiscard]] Eigen::Vector2d middle() const noexcept { return 0.5 * (start + end); }
  /// Squared distance of a point to the segment.
  [[nodiscard]] double squared_distance(const Eigen::Vector2d& p) const noexcept {
    return cue::squared_distance(p, start, end);
  }
};

/// Squared distance of two segments: the mean of what their middles have from the other.
double squared_distance(const Place& a, const Place& b) noexcept {
  return 0.5 * (a.squared_distance(b.middle()) + b.squared_distance(a.middle()));
}

/// A point that speaks for the lines near it.
struct Voice {
  Eigen::Vector2d place;
  double belief = 0.0;  ///< above 0: moves by itself
  double share = 0.0;   ///< of a say
  cue::Nearness nearness;
};

struct Votes {
  double weights = 0.0;
  double sum = 0.0;

  void add(double weight, double belief) noexcept {
    weights += weight;
    sum += weight * belief;
  }
};

/// The points that know something. Returns how many.
std::size_t listen(const FrameMeasurement& frame, std::span<const MotionEvidence> points,
                   const RigCalibration& rig, double event_weight,
                   std::span<Voice> voices) noexcept {
  const Pose T_cam_body = rig.cameras[rig.frame_camera].T_body_cam.inverse();
  std::size_t n = 0;
  for (std::size_t k = 0; k < frame.points.size(); ++k) {
    const PointMeasurement& p = frame.points[k];
    const MotionEvidence& e = points[k];
    if (e.frames == 0 || !std::isfinite(e.belief)) continue;
    Voice& voice = voices[n];
    voice.place = cue::place_of(T_cam_body * rig.cameras[p.camera].T_body_cam, p.bearing_xy,
                                e.depth_known ? e.inverse_depth_pm : 0.0);
    voice.belief = e.belief;
    voice.share = p.kind == FeatureKind::kEventPoint ? event_weight : 1.0;
    voice.nearness = cue::nearness_of(e.inverse_depth_pm, e.inverse_depth_sigma_pm);
    if (voice.place.allFinite()) ++n;
  }
  return n;
}

/// What a line says of itself, and for the lines near it.
struct LineVoice {
  Place place;
  double belief = 0.0;
  double share = 0.0;
};

/// How much nearer a line stands than the points around it.
double doubt_of_near(const LineMotionEvidence& e, const Place& place,
                     std::span<const Voice> voices) noexcept {
  Votes around;
  for (const Voice& v : voices)
    around.add(v.nearness.sure *
                   cue::closeness((v.place - place.middle()).squaredNorm(), cue::kNearnessRadius),
               v.nearness.log_rho);
  if (!(around.weights > cue::kLeastWeight)) return 0.0;
  const double middle_pm = 0.5 * (e.inverse_depth_pm[0] + e.inverse_depth_pm[1]);
  return cue::doubt_of_near(cue::nearness_of(middle_pm, e.inverse_depth_sigma_pm),
                            around.sum / around.weights);
}

}  // namespace

LineMotionCue::LineMotionCue(const MotionCueConfig& config, const RigCalibration& rig) noexcept
    : config_(config), rig_(rig) {
  PLED_CHECK(check(config).key == nullptr);
}

const LineMotionCue::PastFrame& LineMotionCue::past(std::size_t back) const noexcept {
  return past_[(newest_ + limits::kCueFrames - back) % limits::kCueFrames];
}

double LineMotionCue::even_px(const LineMeasurement& line) const noexcept {
  return line.id >= kFirstEventLineId ? config_.event_even_px : config_.even_px;
}

std::optional<std::array<Eigen::Vector2d, 2>> LineMotionCue::ends(FeatureId id, std::size_t back,
                                                                  std::size_t hint) const noexcept {
  if (back >= num_past_) return std::nullopt;
  const PastFrame& frame = past(back);
  const std::optional<std::size_t> at = cue::find({frame.ids.data(), frame.ids.size()}, id, hint);
  if (!at) return std::nullopt;
  const auto& seen = frame.ends[*at];
  return std::array{Eigen::Vector2d(seen[0][0], seen[0][1]),
                    Eigen::Vector2d(seen[1][0], seen[1][1])};
}

void LineMotionCue::reset() noexcept { num_past_ = 0; }

void LineMotionCue::judge(const FrameMeasurement& frame, std::span<const Pose> T_world_body,
                          bool metric, std::span<const MotionEvidence> points,
                          std::span<LineMotionEvidence> out) noexcept {
  PLED_CHECK(points.size() >= frame.points.size() && out.size() >= frame.lines.size());
  for (std::size_t i = 0; i < frame.lines.size(); ++i) {
    out[i] = {};
    fit(frame.lines[i], i, T_world_body, metric, out[i]);
  }
  pool(frame, points, out);
  keep(frame);
}

void LineMotionCue::fit(const LineMeasurement& line, std::size_t index,
                        std::span<const Pose> T_world_body, bool metric,
                        LineMotionEvidence& out) const noexcept {
  if (T_world_body.size() < 2) return;
  const CameraCalibration& camera = rig_.cameras[line.camera];
  const Pose T_world_now = T_world_body[0] * camera.T_body_cam;
  const std::array<Eigen::Vector3d, 2> now{
      Eigen::Vector3d(line.bearing_xy[0][0], line.bearing_xy[0][1], 1.0),
      Eigen::Vector3d(line.bearing_xy[1][0], line.bearing_xy[1][1], 1.0)};
  if (!(now[0].cross(now[1]).norm() > cue::kLeastNormal)) return;
  std::array<cue::LineSight, limits::kCueFrames> sights;
  std::size_t n = 0;
  const std::size_t known = std::min(num_past_, T_world_body.size() - 1);
  for (std::size_t back = 0; back < known; ++back) {
    const auto seen = ends(line.id, back, index);  // a line may be missing for a picture or two
    if (!seen || !(*seen)[0].allFinite() || !(*seen)[1].allFinite()) continue;
    const Pose T_then_now = (T_world_body[back + 1] * camera.T_body_cam).inverse() * T_world_now;
    sights[n++] = cue::sight_of(T_then_now, now, *seen);
  }
  if (n == 0) return;
  const double focal_px = mean_focal_px(camera);
  const double noise = cue::kNoiseOfEven * even_px(line) / focal_px;
  const cue::DepthsFit fit = cue::best_depths(std::span(sights).first(n), noise);
  if (!std::isfinite(fit.squares) || !std::isfinite(fit.sigma)) return;
  out.inverse_depth_pm = {fit.rho[0], fit.rho[1]};
  out.inverse_depth_sigma_pm = noise * fit.sigma;
  out.depth_known =
      metric && out.inverse_depth_sigma_pm < cue::kWellKnown * std::min(fit.rho[0], fit.rho[1]);
  out.freedoms = 2.0 * static_cast<double>(n) - fit.free_depths;
  out.frames = static_cast<std::uint8_t>(n);
  if (out.freedoms >= kLeastFreedoms)
    out.residual_px = focal_px * std::sqrt(fit.squares / out.freedoms);
}

void LineMotionCue::pool(const FrameMeasurement& frame, std::span<const MotionEvidence> points,
                         std::span<LineMotionEvidence> out) const noexcept {
  std::array<Voice, limits::kMaxPoints> heard;
  const std::span<const Voice> voices =
      std::span(heard).first(listen(frame, points, rig_, config_.event_weight, heard));
  const Pose T_cam_body = rig_.cameras[rig_.frame_camera].T_body_cam.inverse();
  std::array<LineVoice, limits::kMaxLines> lines;
  const std::size_t n = frame.lines.size();
  for (std::size_t i = 0; i < n; ++i) {
    const LineMeasurement& line = frame.lines[i];
    const LineMotionEvidence& e = out[i];
    const Pose T = T_cam_body * rig_.cameras[line.camera].T_body_cam;
    const auto place = [&](std::size_t k) {
      return cue::place_of(T, line.bearing_xy[k], e.depth_known ? e.inverse_depth_pm[k] : 0.0);
    };
    lines[i].place = {place(0), place(1)};
    if (!(e.freedoms >= kLeastFreedoms)) continue;
    const double free = 0.5 * (2.0 * e.frames - e.freedoms);
    lines[i].belief = cue::belief_of(e.residual_px, even_px(line));
    lines[i].share = lines[i].belief > 0.0 ? 1.0 : 1.0 - (1.0 - kWordOfFree) * free;
    if (line.id >= kFirstEventLineId) lines[i].share *= config_.event_weight;
    lines[i].belief += doubt_of_near(e, lines[i].place, voices);
  }
  for (std::size_t i = 0; i < n; ++i) {
    Votes votes;
    votes.add(config_.own_weight * lines[i].share, lines[i].belief);
    for (const Voice& v : voices)
      votes.add(
          v.share * cue::closeness(lines[i].place.squared_distance(v.place), config_.pool_radius),
          v.belief);
    for (std::size_t k = 0; k < n; ++k)
      if (k != i && lines[k].share > 0.0)
        votes.add(lines[k].share * cue::closeness(squared_distance(lines[i].place, lines[k].place),
                                                  config_.pool_radius),
                  lines[k].belief);
    if (!(votes.weights > cue::kLeastWeight)) continue;
    out[i].w_static = cue::rest_of(votes.sum / (votes.weights + cue::kDoubt), config_.steepness);
  }
}

void LineMotionCue::keep(const FrameMeasurement& frame) noexcept {
  newest_ = (newest_ + 1) % limits::kCueFrames;
  num_past_ = std::min(num_past_ + 1, limits::kCueFrames);
  PastFrame& kept = past_[newest_];
  kept.ids.clear();
  for (std::size_t i = 0; i < frame.lines.size(); ++i) {
    PLED_CHECK(kept.ids.push_back(frame.lines[i].id));
    kept.ends[i] = frame.lines[i].bearing_xy;
  }
}

}  // namespace pled
