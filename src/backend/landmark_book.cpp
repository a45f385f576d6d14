#include "pled_vins/backend/landmark_book.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "pled_vins/backend/feature_loss.hpp"
#include "src/backend/solver_choice.hpp"

namespace pled {
namespace {

constexpr double kMinInverseDepth = -0.02;  ///< 1/m; a little past infinity is noise
constexpr double kMaxInverseDepth = 10.0;   ///< 1/m: nearer than 10 cm is wrong
constexpr double kDefaultInverseDepth = 0.3;
constexpr double kWeakInformation = 10.0;  ///< below, the depth is held by the scene's
constexpr double kMaxStartSquared = 25.0;  ///< sigmas^2 a sighting, of a point with a new depth
constexpr double kSureParallax = 5.0;  ///< sigmas a sighting; a smaller one tells no wrong point

Pose T_cj_ci(const PointFrames& f) {
  return (f.T_world_body_j * f.T_body_cam_j).inverse() * (f.T_world_body_i * f.T_body_cam_i);
}

/// The depth that makes the rays meet best: b x (R a + rho t) = 0 over all sightings.
double linear_inverse_depth(const SlidingWindow& window, const RigCalibration& rig,
                            const Landmark& landmark) {
  const auto& seen = landmark.observations;
  const Eigen::Vector3d a{seen[0].xy[0], seen[0].xy[1], 1.0};
  double num = 0, den = 1e-9;
  for (std::size_t k = 1; k < seen.size(); ++k) {
    const Pose T = T_cj_ci(point_frames(window, rig, seen[0], seen[k], false));
    const Eigen::Vector3d b{seen[k].xy[0], seen[k].xy[1], 1.0};
    const Eigen::Vector3d bt = b.cross(T.p);
    num -= bt.dot(b.cross(T.q * a));
    den += bt.squaredNorm();
  }
  return num / den;
}

}  // namespace

std::optional<DepthEstimate> estimate_depth(const SlidingWindow& window, const RigCalibration& rig,
                                            const FactorSettings& settings,
                                            const Landmark& landmark) noexcept {
  if (landmark.observations.size() < 2) return std::nullopt;
  Landmark trial = landmark;
  const auto& seen = trial.observations;
  double& rho = trial.bearing_depth[2];
  trial.bearing_depth = {seen[0].xy[0], seen[0].xy[1], 0};
  rho = std::clamp(linear_inverse_depth(window, rig, landmark), 1e-3, 5.0);
  DepthEstimate out;
  constexpr int kSteps = 4;
  for (int step = 0; step <= kSteps; ++step) {
    double h = 1e-9, g = 0, squared = 0;
    for (std::size_t k = 1; k < seen.size(); ++k) {
      Eigen::Vector2d r;
      PointJacobians J;
      evaluate_point(window, rig, settings, trial, seen[k], r, &J);
      const double w = cauchy_weight(r.squaredNorm(), 2.0 * settings.robust_scale);
      h += w * J.point.col(2).squaredNorm();
      g += w * J.point.col(2).dot(r);
      squared += r.squaredNorm();
    }
    out = {rho, h, squared / static_cast<double>(seen.size() - 1)};
    if (step < kSteps) rho = std::clamp(rho - g / h, kMinInverseDepth, 5.0);
  }
  if (!std::isfinite(out.inverse_depth_pm + out.information + out.mean_squared))
    return std::nullopt;
  return out;
}

void LandmarkBook::observe(SlidingWindow& window, const FrameMeasurement& frame,
                           std::size_t state) const noexcept {
  for (const PointMeasurement& point : frame.points) {
    if (!point.inlier) continue;
    Landmark* landmark = window.find(point.id);
    if (landmark && landmark->rejected && parked_again(point.w_temporal, landmark->reliability)) {
      *landmark = {};
      landmark->id = point.id;
    }
    if (!landmark) {
      Landmark fresh;
      fresh.id = point.id;
      if (!window.landmarks.push_back(fresh)) continue;
      landmark = &window.landmarks.back();
    }
    (void)landmark->observations.push_back({static_cast<std::uint8_t>(state), point.camera,
                                            point.bearing_xy, point.bearing_rate_xyps, point.kind});
    note_time(point.w_temporal, landmark->reliability);
    if (landmark->age < 60000) ++landmark->age;
  }
  window.erase_landmarks([state](const Landmark& l) {
    if (l.observations.empty()) return true;
    const bool live = l.observations.back().state == state;
    return !live && (l.observations.size() < 2 || l.rejected);
  });
}

double LandmarkBook::median_inverse_depth(const SlidingWindow& window) const noexcept {
  std::array<double, kMaxLandmarks> values;
  std::size_t n = 0;
  for (const Landmark& l : window.landmarks)
    if (l.has_depth && !l.rejected && !l.weak_depth) values[n++] = l.inverse_depth_pm();
  if (n < 5) return kDefaultInverseDepth;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(n / 2);
  std::nth_element(values.begin(), middle, values.begin() + static_cast<std::ptrdiff_t>(n));
  return std::max(*middle, 1e-3);
}

void LandmarkBook::give_depth(SlidingWindow& window, Landmark& landmark,
                              double scene_pm) const noexcept {
  const std::optional<DepthEstimate> depth = estimate_depth(window, rig_, settings_, landmark);
  landmark.has_depth = false;
  if (!depth) return;
  // A new point whose rays do not meet at all moves, or is mistracked.
  if (depth->information > kWeakInformation && depth->mean_squared > kMaxStartSquared) return;
  const double belief = 1.0 / (settings_.depth_sigma_pm * settings_.depth_sigma_pm);
  landmark.weak_depth = depth->information < kWeakInformation;
  landmark.prior_inverse_depth_pm = scene_pm;
  double rho = depth->inverse_depth_pm;
  if (landmark.weak_depth)
    rho = (depth->information * rho + belief * scene_pm) / (depth->information + belief);
  const Observation& anchor = landmark.observations[0];
  landmark.bearing_depth = {anchor.xy[0], anchor.xy[1], rho};
  landmark.has_depth = true;
}

std::size_t LandmarkBook::prepare(SlidingWindow& window) const noexcept {
  const double scene_pm = median_inverse_depth(window);
  return choose_for_solver<limits::kMaxPoints>(window.landmarks, window.size() - 1,
                                               min_observations_, [&](Landmark& l) {
                                                 if (!l.has_depth || l.weak_depth)
                                                   give_depth(window, l, scene_pm);
                                                 return l.has_depth;
                                               });
}

double LandmarkBook::judge(SlidingWindow& window) const noexcept {
  double squared_px = 0;
  std::size_t count = 0;
  for (Landmark& l : window.landmarks) {
    if (!l.in_solver) continue;
    std::array<double, limits::kWindowStates> squares;
    double weights = 0, squared = 0, information = 0;
    bool behind = false;
    for (std::size_t k = 0; k < l.observations.size(); ++k) {
      Eigen::Vector2d r;
      PointJacobians J;
      J.with_extrinsic = false;
      behind |= !evaluate_point(window, rig_, settings_, l, l.observations[k], r, &J);
      information += J.point.col(2).squaredNorm();
      weights += cauchy_weight(r.squaredNorm(), settings_.robust_scale);
      squares[k] = r.squaredNorm();
      squared += squares[k];
    }
    const double m = static_cast<double>(l.observations.size());
    l.weight = weights / m;
    l.depth_information_m2 = information;
    const double rho = l.inverse_depth_pm();
    const bool deep = rho > kMinInverseDepth && rho < kMaxInverseDepth;
    if ((behind || !deep) && rho * rho * information < kSureParallax * kSureParallax * m) {
      // A shift that an error of the poses, which all points share, may have made: a depth nobody
      // knows yet, not a wrong point. Were it rejected, those that agree with the error would stay.
      l.has_depth = l.in_solver = false;
      continue;
    }
    if (behind || !deep) l.weight = 0.0;
    weigh(settings_, std::span(squares).first(l.observations.size()), l.reliability);
    conclude(settings_, false, l.reliability);
    l.rejected = !agrees(settings_, l.weight) || behind || !deep;
    if (l.rejected) continue;
    const double px = mean_focal_px(rig_.cameras[rig_.frame_camera]) /
                      settings_.weight_of(l.observations[0].kind, rig_.frame_camera);
    squared_px += squared * px * px;
    count += 2 * l.observations.size() - 3;  // three figures are the point's own
  }
  return count == 0 ? 0.0 : std::sqrt(squared_px / static_cast<double>(count));
}

}  // namespace pled
