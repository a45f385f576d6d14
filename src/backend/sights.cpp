#include "pled_vins/backend/sights.hpp"

#include <algorithm>

namespace pled {
namespace {

/// kEvaluate: evaluate_point or evaluate_line.
template <auto kEvaluate, typename AnyLandmark, typename Jacobians>
void evaluate_all(const SlidingWindow& window, const RigCalibration& rig,
                  const FactorSettings& settings, const AnyLandmark& landmark, std::size_t count,
                  Sights<Jacobians>& out) noexcept {
  const auto& seen = landmark.observations;
  out.count = std::min(count, seen.size());
  for (std::size_t k = 0; k < out.count; ++k) {
    out.J[k].with_extrinsic = settings.estimate_extrinsic;
    kEvaluate(window, rig, settings, landmark, seen[k], out.r[k], &out.J[k]);
    out.squares[k] = out.r[k].squaredNorm();
  }
}

template <auto kEvaluate, typename AnyLandmark>
SquaredSights squares_of(const SlidingWindow& window, const RigCalibration& rig,
                         const FactorSettings& settings, const AnyLandmark& landmark) noexcept {
  SquaredSights out;
  for (const auto& seen : landmark.observations) {
    Eigen::Vector2d r;
    out.visible &= kEvaluate(window, rig, settings, landmark, seen, r, nullptr);
    out.squares[out.count++] = r.squaredNorm();
  }
  return out;
}

}  // namespace

void evaluate_sights(const SlidingWindow& window, const RigCalibration& rig,
                     const FactorSettings& settings, const Landmark& landmark, std::size_t count,
                     PointSights& out) noexcept {
  evaluate_all<evaluate_point>(window, rig, settings, landmark, count, out);
}

void evaluate_sights(const SlidingWindow& window, const RigCalibration& rig,
                     const FactorSettings& settings, const LineLandmark& landmark,
                     std::size_t count, LineSights& out) noexcept {
  evaluate_all<evaluate_line>(window, rig, settings, landmark, count, out);
}

SquaredSights squared_sights(const SlidingWindow& window, const RigCalibration& rig,
                             const FactorSettings& settings, const Landmark& landmark) noexcept {
  return squares_of<evaluate_point>(window, rig, settings, landmark);
}

SquaredSights squared_sights(const SlidingWindow& window, const RigCalibration& rig,
                             const FactorSettings& settings,
                             const LineLandmark& landmark) noexcept {
  return squares_of<evaluate_line>(window, rig, settings, landmark);
}

}  // namespace pled
