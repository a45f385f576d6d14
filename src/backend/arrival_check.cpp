#include "src/backend/arrival_check.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace pled {
namespace {

constexpr double kGateSigmas = 4.0;
// Of the newest camera against those that saw a feature before, some tenths of a second back.
constexpr double kTurn_rad = 2e-3;
constexpr double kPlace_m = 0.01;
// Errors of tracks that last do not show in what they leave over: a depth is known less well than
// its sightings claim.
constexpr double kLastingError_px = 0.5;
constexpr double kDepthSigmas = 10.0;
constexpr double kNearest_m = 0.3;     ///< of a point whose depth is not known
constexpr double kLineError_px = 1.5;  ///< of where a line is taken to be
constexpr int kMaxStrikes = 3;

struct InverseDepths {
  double farthest_pm = 0.0;
  double nearest_pm = 1.0 / kNearest_m;
};

/// How far on the way from a to b it is nearest to the origin, 0 ... 1.
double nearest_on_piece(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double squared = along.squaredNorm();
  return squared > 0.0 ? std::clamp(-a.dot(along) / squared, 0.0, 1.0) : 0.0;
}

InverseDepths depths_of(const Landmark& landmark) {
  const bool known =
      landmark.has_depth && !landmark.weak_depth && landmark.depth_information_m2 > 0.0;
  if (!known) return {};
  const double slack = kDepthSigmas / std::sqrt(landmark.depth_information_m2);
  return {std::max(0.0, landmark.inverse_depth_pm() - slack), landmark.inverse_depth_pm() + slack};
}

/// Sigmas from its newest sighting to where it may be seen; none where that cannot be told.
std::optional<double> miss_of(const SlidingWindow& window, const RigCalibration& rig,
                              const FactorSettings& settings, Landmark& landmark) {
  const Observation& seen = landmark.observations.back();
  const InverseDepths depths = depths_of(landmark);
  const std::array<double, 3> kept = landmark.bearing_depth;
  if (!landmark.has_depth)
    landmark.bearing_depth = {landmark.observations[0].xy[0], landmark.observations[0].xy[1], 0.0};
  Eigen::Vector2d far, near;
  landmark.bearing_depth[2] = depths.farthest_pm;
  const bool in_front = evaluate_point(window, rig, settings, landmark, seen, far, nullptr);
  landmark.bearing_depth[2] = depths.nearest_pm;
  if (!evaluate_point(window, rig, settings, landmark, seen, near, nullptr)) near = far;
  landmark.bearing_depth = kept;
  if (!in_front) return std::nullopt;

  const double per_radian = settings.weight_of(seen.kind, seen.camera);  // sigmas on z = 1
  const double lasting = kLastingError_px / mean_focal_px(rig.cameras[seen.camera]);
  const double s = nearest_on_piece(far, near);
  // Along the piece the shift grows about as the inverse depth does.
  const double place = kPlace_m * std::lerp(depths.farthest_pm, depths.nearest_pm, s);
  const double own = std::hypot(kTurn_rad, lasting, place) * per_radian;
  return (far + s * (near - far)).norm() / std::sqrt(1.0 + own * own);
}

std::optional<double> miss_of(const SlidingWindow& window, const RigCalibration& rig,
                              const FactorSettings& settings, LineLandmark& line) {
  const LineObservation& seen = line.observations.back();
  Eigen::Vector2d ends;
  if (!line.has_line || !evaluate_line(window, rig, settings, line, seen, ends, nullptr))
    return std::nullopt;
  const double per_radian = settings.weight_of(FeatureKind::kLine, seen.camera);
  const double lasting = kLineError_px / mean_focal_px(rig.cameras[seen.camera]);
  const double own = std::hypot(kTurn_rad, lasting) * per_radian;
  return ends.cwiseAbs().maxCoeff() / std::sqrt(1.0 + own * own);
}

template <typename Features>
void turn_away(SlidingWindow& window, const RigCalibration& rig, const FactorSettings& settings,
               Features& features) {
  const std::size_t newest = window.size() - 1;
  for (auto& feature : features) {
    auto& seen = feature.observations;
    if (feature.rejected || seen.size() < 2 || seen.back().state != newest) continue;
    const std::optional<double> miss = miss_of(window, rig, settings, feature);
    if (!miss || *miss < kGateSigmas) {
      feature.strikes = 0;
      continue;
    }
    seen.pop_back();
    feature.rejected = ++feature.strikes >= kMaxStrikes;
  }
}

}  // namespace

void turn_away_movers(SlidingWindow& window, const RigCalibration& rig,
                      const FactorSettings& settings) noexcept {
  if (settings.robust.mode != RobustMode::kPerObservation) return;  // no part of what is published
  turn_away(window, rig, settings, window.landmarks);
  turn_away(window, rig, settings, window.lines);
}

}  // namespace pled
