#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "pled_vins/core/config_issue.hpp"

/// One weight in [0, 1] per feature, point or line, which the back end chooses together with the
/// states: the robust loss of the paper, eq. (9), and its minimiser in closed form.
namespace pled {

/// The loss rho(w) of a feature whose observations have squared residuals s_i = |r_i|^2, with
/// w~ the weight it had before and n_j a count that makes a long-known weight slow:
enum class RobustMode : std::uint8_t {
  /// w^2 sum_i s_i with w held at 1: the estimator without weights, to compare with. As in those of
  /// the VINS family that the weights of paper and DynaVINS are to improve on, s_i are robust
  /// losses of the sightings (Cauchy's, see sight_loss()), and features that do not fit are set
  /// aside.
  /// A backend.robust_scale of 100 makes that plain least squares.
  kNone,
  /// sum_i [ w^2 s_i + l_w (1 - w)^2 + l_m n_j^2 (w~ - w)^2 + l_z (z - w)^2 ],
  /// n_j = min(observations, 10). Ours: the loss of the paper with its lambdas per observation, and
  /// what time tells (z) as one more term. A weight tells the mean error, not how long a track is;
  /// information grows with the track all the same.
  kPerObservation,
  /// w^2 sum_i s_i + l_w (1 - w)^2 + l_m n_j^2 (w~ - w)^2, n_j = observations: eq. (9), as printed.
  /// At the same error a track of ten observations weighs far less than one of three.
  kPaper,
  /// sum_i h(w^2 s_i) + h(l_w^2 (1 - w)^2) + h(l_m^2 n_j^2 (w~ - w)^2), n_j = rounds, h Huber's
  /// loss
  /// of a squared residual with scale 1: DynaVINS as published in code. Its lambdas multiply
  /// residuals, so they are squared here. It leaves features with fewer than 4 observations at 1.
  kDynavins,
};

/// Residuals in sigmas make these portable. Without momentum w = 1/2 where the mean of s_i is
/// lambda_w (kPerObservation) or their sum is (kPaper).
struct RobustWeightConfig {
  RobustMode mode = RobustMode::kPerObservation;
  /// l_w, 0.01 ... 1000. A track of 1 sigma an axis has s = 2 and by itself gets l_w / (l_w + 2).
  /// Chosen with lambda_m and lambda_z on simulated sequences (seeds 1 to 8 of the development
  /// set). Paper and DynaVINS: 2 on VIODE; paper: 8 on DAVIS 240C, 2 on DSEC.
  double lambda_w = 4.0;
  /// l_m, 0 ... 1000. Paper: 0.2, 1 and 2; DynaVINS: 0.2.
  double lambda_m = 0.1;
};

[[nodiscard]] constexpr ConfigIssue check(const RobustWeightConfig& c) noexcept {
  if (!(c.lambda_w >= 0.01 && c.lambda_w <= 1000))
    return {"robust.lambda_w", "must be in [0.01, 1000]"};
  if (!(c.lambda_m >= 0 && c.lambda_m <= 1000)) return {"robust.lambda_m", "must be in [0, 1000]"};
  return {};
}
static_assert(check(RobustWeightConfig{}).key == nullptr, "defaults must be valid");

/// Whether residuals are weighted as published: no other loss inside, one noise for all features.
[[nodiscard]] constexpr bool as_published(RobustMode mode) noexcept {
  return mode == RobustMode::kPaper || mode == RobustMode::kDynavins;
}

/// f / sigma_px of the paper's code, whatever the camera: 1.5 px at f = 460 px.
inline constexpr double kPaperSigmasPerUnit = 460.0 / 1.5;

/// What speaks for and against a feature.
struct RobustEvidence {
  std::span<const double> squared;  ///< s_i of each observation in the window, whitened, >= 0
  double previous = 1.0;            ///< w~: the last (fused) weight; 1 for a new feature
  std::uint32_t rounds = 1;  ///< kDynavins: frames in which it was weighed, this one included
  /// z: what time tells, 1 at rest, 0 moving; NaN: nothing. Only kPerObservation heeds it.
  double temporal = std::numeric_limits<double>::quiet_NaN();
  double lambda_z = 0.0;  ///< l_z: fusion.lambda_z, finite, >= 0
};

/// The weight in [0, 1] that minimises the loss: exact, no iteration. Parabolas have their minimum
/// at (l_w + M w~ + l_z z) / (S + l_w + M + l_z); Huber's has a slope of straight pieces, whose
/// zero is found among their ends.
/// @returns nullopt when the settings are out of range, there is no observation, or a value is not
///          finite or negative; a z of NaN is no such value.
/// Cost: O(m), kDynavins O(m^2), for m observations; no allocation.
[[nodiscard]] std::optional<double> robust_weight(const RobustWeightConfig& config,
                                                  const RobustEvidence& evidence) noexcept;

/// rho(w): what the feature adds to the cost of states and weights together. Sums of squares, not
/// halves of them.
[[nodiscard]] double robust_loss(const RobustWeightConfig& config, const RobustEvidence& evidence,
                                 double w) noexcept;

/// d(rho) / d(s_i) at constant w: what multiplies |r_i|^2 in the normal equations of a solve, and
/// in marginalisation, where a weight left free would take the feature's whole gradient with it.
[[nodiscard]] double observation_gain(const RobustWeightConfig& config, double squared,
                                      double w) noexcept;

}  // namespace pled
