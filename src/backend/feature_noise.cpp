#include "pled_vins/backend/feature_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pled_vins/backend/sights.hpp"
#include "pled_vins/geometry/camera.hpp"

namespace pled {
namespace {

constexpr std::size_t kFewestSightings = 4;
constexpr std::size_t kFewestLandmarks = 10;
constexpr double kFollow = 0.1;     ///< share of the difference taken over a frame: about 0.5 s
constexpr double kMostGrowth = 10;  ///< times the least noise; beyond, it is not noise

/// Variances per degree of freedom, one for each landmark that is seen often enough.
class Variances {
 public:
  /// @param own  degrees of freedom that the landmark itself took
  void add(const SquaredSights& sights, double sigma_px, std::size_t own) noexcept {
    if (sights.count < kFewestSightings || n_ == values_px2_.size()) return;
    double squared = 0.0;
    for (const double s : sights.span()) squared += s;
    // Chi-square with k degrees of freedom has its median at k (1 - 2 / 9k)^3 (Wilson-Hilferty).
    const double k = static_cast<double>(2 * sights.count - own);
    const double c = 1.0 - 2.0 / (9.0 * k);
    values_px2_[n_++] = squared * sigma_px * sigma_px / (k * c * c * c);
  }

  /// Root of their median; NaN with too few.
  [[nodiscard]] double sigma_px() noexcept {
    if (n_ < kFewestLandmarks) return std::numeric_limits<double>::quiet_NaN();
    const auto middle = values_px2_.begin() + static_cast<std::ptrdiff_t>(n_ / 2);
    std::nth_element(values_px2_.begin(), middle,
                     values_px2_.begin() + static_cast<std::ptrdiff_t>(n_));
    return std::sqrt(*middle);
  }

 private:
  std::array<double, kMaxLandmarks> values_px2_;
  std::size_t n_ = 0;
};

}  // namespace

void FeatureNoise::observe(const SlidingWindow& window, const RigCalibration& rig,
                           const FactorSettings& settings) noexcept {
  const auto sigma_px = [&](FeatureKind kind, std::uint8_t camera) {
    return mean_focal_px(rig.cameras[camera]) / settings.weight_of(kind, camera);
  };
  for (const FeatureKind kind : {FeatureKind::kImagePoint, FeatureKind::kEventPoint}) {
    Variances variances;
    for (const Landmark& landmark : window.landmarks) {
      if (!landmark.in_solver || landmark.observations[0].kind != kind) continue;
      variances.add(squared_sights(window, rig, settings, landmark),
                    sigma_px(kind, landmark.observations[0].camera), kPointDim);
    }
    follow(kind, variances.sigma_px());
  }
  Variances variances;
  for (const LineLandmark& line : window.lines) {
    if (!line.in_solver) continue;
    variances.add(squared_sights(window, rig, settings, line),
                  sigma_px(FeatureKind::kLine, line.observations[0].camera), kLineDim);
  }
  follow(FeatureKind::kLine, variances.sigma_px());
}

void FeatureNoise::follow(FeatureKind kind, double now_px) noexcept {
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
