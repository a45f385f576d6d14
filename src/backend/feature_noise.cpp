#include "pled_vins/backend/feature_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pled_vins/geometry/camera.hpp"

namespace pled {
namespace {

constexpr std::size_t kFewestSightings = 4;
constexpr std::size_t kFewestPoints = 10;
constexpr double kFollow = 0.1;     ///< share of the difference taken over a frame: about 0.5 s
constexpr double kMostGrowth = 10;  ///< times the least noise; beyond, it is not noise

}  // namespace

void FeatureNoise::observe(const SlidingWindow& window, const RigCalibration& rig,
                         const FactorSettings& settings) noexcept {
  observe_kind(FeatureKind::kImagePoint, window, rig, settings);
  observe_kind(FeatureKind::kEventPoint, window, rig, settings);
}

void FeatureNoise::observe_kind(FeatureKind kind, const SlidingWindow& window,
                              const RigCalibration& rig, const FactorSettings& settings) noexcept {
  std::array<double, kMaxLandmarks> variance_px2;
  std::size_t n = 0;
  for (const Landmark& landmark : window.landmarks) {
    const std::size_t m = landmark.observations.size();
    if (!landmark.in_solver || m < kFewestSightings) continue;
    if (landmark.observations[0].kind != kind) continue;
    double squared_px2 = 0.0;
    for (const Observation& seen : landmark.observations) {
      Eigen::Vector2d r;
      if (!evaluate_point(window, rig, settings, landmark, seen, r, nullptr)) continue;
      const double sigma_px =
          mean_focal_px(rig.cameras[seen.camera]) / settings.weight_of(kind, seen.camera);
      squared_px2 += r.squaredNorm() * sigma_px * sigma_px;
    }
    // Chi-square with k degrees of freedom has its median at k (1 - 2 / 9k)^3 (Wilson-Hilferty).
    const double k = static_cast<double>(2 * m - 3);
    const double c = 1.0 - 2.0 / (9.0 * k);
    variance_px2[n++] = squared_px2 / (k * c * c * c);
  }
  if (n < kFewestPoints) return;
  const auto middle = variance_px2.begin() + static_cast<std::ptrdiff_t>(n / 2);
  std::nth_element(variance_px2.begin(), middle,
                   variance_px2.begin() + static_cast<std::ptrdiff_t>(n));
  const double now_px = std::sqrt(*middle);
  if (!std::isfinite(now_px)) return;
  double& measured_px = measured_px_[static_cast<std::size_t>(kind)];
  measured_px += kFollow * (now_px - measured_px);
}

FeatureSigmas FeatureNoise::sigmas_px() const noexcept {
  FeatureSigmas out;
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = std::clamp(measured_px_[k], least_px_[k], kMostGrowth * least_px_[k]);
  return out;
}

}  // namespace pled
