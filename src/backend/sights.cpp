#include "pled_vins/backend/sights.hpp"

#include <algorithm>

namespace pled {

void evaluate_sights(const SlidingWindow& window, const RigCalibration& rig,
                     const FactorSettings& settings, const Landmark& landmark, std::size_t count,
                     PointSights& out) noexcept {
  const auto& seen = landmark.observations;
  out.count = std::min(count, seen.size());
  for (std::size_t k = 0; k < out.count; ++k) {
    out.J[k].with_extrinsic = settings.estimate_extrinsic;
    evaluate_point(window, rig, settings, landmark, seen[k], out.r[k], &out.J[k]);
    out.squares[k] = out.r[k].squaredNorm();
  }
}

void evaluate_sights(const SlidingWindow& window, const RigCalibration& rig,
                     const FactorSettings& settings, const LineLandmark& landmark,
                     std::size_t count, LineSights& out) noexcept {
  const auto& seen = landmark.observations;
  out.count = std::min(count, seen.size());
  for (std::size_t k = 0; k < out.count; ++k) {
    out.J[k].with_extrinsic = settings.estimate_extrinsic;
    evaluate_line(window, rig, settings, landmark, seen[k], out.r[k], &out.J[k]);
    out.squares[k] = out.r[k].squaredNorm();
  }
}

SquaredSights squared_sights(const SlidingWindow& window, const RigCalibration& rig,
                             const FactorSettings& settings, const Landmark& landmark) noexcept {
  SquaredSights out;
  for (const Observation& seen : landmark.observations) {
    Eigen::Vector2d r;
    out.visible &= evaluate_point(window, rig, settings, landmark, seen, r, nullptr);
    out.squares[out.count++] = r.squaredNorm();
  }
  return out;
}

SquaredSights squared_sights(const SlidingWindow& window, const RigCalibration& rig,
                             const FactorSettings& settings,
                             const LineLandmark& landmark) noexcept {
  SquaredSights out;
  for (const LineObservation& seen : landmark.observations) {
    Eigen::Vector2d r;
    out.visible &= evaluate_line(window, rig, settings, landmark, seen, r, nullptr);
    out.squares[out.count++] = r.squaredNorm();
  }
  return out;
}

}  // namespace pled
