#include "pled_vins/backend/line_book.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "pled_vins/backend/feature_loss.hpp"
#include "pled_vins/backend/sights.hpp"
#include "pled_vins/geometry/line_triangulation.hpp"
#include "src/backend/solver_choice.hpp"

namespace pled {
namespace {

constexpr double kMaxStartSquared = 25.0;  ///< sigmas^2 a sighting, of a new line

Eigen::Vector2d middle_of(const LineObservation& seen) noexcept {
  return {0.5 * (seen.start_xy[0] + seen.end_xy[0]), 0.5 * (seen.start_xy[1] + seen.end_xy[1])};
}

/// Whether the line is in front of a camera where that saw the middle of it.
bool in_front(const SlidingWindow& window, const RigCalibration& rig, const LineLandmark& line,
              const LineObservation& seen) noexcept {
  Pose T_line_cam = window.state(seen.state).x.T_world_body() * window.T_body_cam(seen.camera, rig);
  T_line_cam.p -= line.origin_world();
  return point_seen_at(T_line_cam.inverse() * to_plucker(line.line()), middle_of(seen)).has_value();
}

}  // namespace

void LineBook::observe(SlidingWindow& window, const FrameMeasurement& frame,
                       std::size_t state) const noexcept {
  for (const LineMeasurement& seen : frame.lines) {
    if (!seen.inlier) continue;
    LineLandmark* line = window.find_line(seen.id);
    if (line && line->rejected && parked_again(seen.w_temporal, line->reliability)) {
      const FeatureId id = line->id;
      *line = {};
      line->id = id;
    }
    if (!line) {
      LineLandmark fresh;
      fresh.id = seen.id;
      if (!window.lines.push_back(fresh)) continue;
      line = &window.lines.back();
    }
    (void)line->observations.push_back({static_cast<std::uint8_t>(state), seen.camera,
                                        seen.bearing_xy[0], seen.bearing_xy[1],
                                        seen.bearing_rate_xyps[0], seen.bearing_rate_xyps[1]});
    note_time(seen.w_temporal, line->reliability);
    line->reliability.alpha_line = seen.alpha_line;
    if (line->age < 60000) ++line->age;
  }
  window.erase_lines([state](const LineLandmark& l) {
    if (l.observations.empty()) return true;
    const bool live = l.observations.back().state == state;
    return !live && (l.observations.size() < 2 || l.rejected);
  });
}

void LineBook::triangulate(SlidingWindow& window, LineLandmark& line) const noexcept {
  std::array<SegmentView, limits::kWindowStates> views;
  const auto& seen = line.observations;
  for (std::size_t k = 0; k < seen.size(); ++k)
    views[k] = {
        window.state(seen[k].state).x.T_world_body() * window.T_body_cam(seen[k].camera, rig_),
        {seen[k].start_xy[0], seen[k].start_xy[1]},
        {seen[k].end_xy[0], seen[k].end_xy[1]}};
  LineTriangulationRules rules;
  rules.sigma_xy = 1.0 / settings_.weight_of(FeatureKind::kLine, seen[0].camera);
  const std::optional<TriangulatedLine> found =
      triangulate_line(std::span(views).first(seen.size()), rules);
  line.has_line = false;
  // A new line whose planes do not meet at all moves, or is mistracked.
  if (!found || found->rms_error > std::sqrt(kMaxStartSquared) * rules.sigma_xy) return;
  const Eigen::Vector3d origin = views[0].T_world_cam.p;
  const std::optional<OrthonormalLine> orthonormal =
      to_orthonormal(line_through(found->start_world - origin, found->end_world - origin));
  if (!orthonormal) return;
  line.set_line(*orthonormal);
  line.origin_world_m = {origin.x(), origin.y(), origin.z()};
  line.has_line = true;
}

std::size_t LineBook::prepare(SlidingWindow& window) const noexcept {
  return choose_for_solver<limits::kMaxLines>(window.lines, window.size() - 1, min_observations_,
                                              [&](LineLandmark& line) {
                                                if (!line.has_line) triangulate(window, line);
                                                return line.has_line;
                                              });
}

void LineBook::judge(SlidingWindow& window) const noexcept {
  for (LineLandmark& line : window.lines) {
    if (!line.in_solver) continue;
    const SquaredSights sights = squared_sights(window, rig_, settings_, line);
    double weights = 0;
    bool seen = sights.visible;
    for (std::size_t k = 0; k < sights.count; ++k) {
      weights += cauchy_weight(sights.squares[k], settings_.robust_scale);
      seen = seen && in_front(window, rig_, line, line.observations[k]);
    }
    line.weight = weights / static_cast<double>(sights.count);
    weigh(settings_, sights.span(), line.reliability);
    conclude(settings_, true, line.reliability);
    line.rejected = !seen || !agrees(settings_, line.weight);
  }
}

}  // namespace pled
