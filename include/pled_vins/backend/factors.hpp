#pragma once

#include <array>

#include <Eigen/Core>

#include "pled_vins/backend/config.hpp"
#include "pled_vins/backend/point_residual.hpp"
#include "pled_vins/backend/window.hpp"

namespace pled {

/// How residuals are weighted: settings turned into the figures that factors use.
struct FactorSettings {
  /// f / sigma_px of each kind of feature in each camera
  std::array<std::array<double, limits::kMaxCameras>, kFeatureKinds> sigmas_per_unit{};
  double robust_scale = 2.0;  ///< c of the Cauchy loss, sigmas
  double sight_gain = 1.0;    ///< multiplies the cost of points and lines, see robust_gain()
  RobustWeightConfig robust;
  FusionConfig fusion;
  double depth_sigma_pm = 0.5;  ///< belief about the depth of a point without parallax
  // A rig that moves off is noticed when it has gone a few millimetres, at some 2 cm/s: until then
  // every state claims to stand (see WindowState::still_share).
  double still_speed_sigma_mps = 0.02;
  double still_position_sigma_m = 0.005;
  double still_angle_sigma_rad = 0.0015;
  double extrinsic_sigma_m = 0.01;
  double extrinsic_sigma_rad = 0.01;
  double time_shift_sigma_s = 0.005;
  bool first_estimates = true;  ///< Jacobians of states known to the prior at their first estimate
  bool estimate_extrinsic = false;
  bool estimate_time_shift = false;

  [[nodiscard]] double weight_of(FeatureKind kind, std::size_t camera) const noexcept {
    return sigmas_per_unit[static_cast<std::size_t>(kind)][camera];
  }
};

/// Noise of each kind of feature, one axis, pixels: of a point, of a line's end across the line.
using FeatureSigmas = std::array<double, kFeatureKinds>;

/// Weighs the features of every camera of the rig as having this noise; the paper's modes have one
/// noise of their own for all (kPaperSigmasPerUnit).
void set_feature_noise(FactorSettings& settings, const RigCalibration& rig,
                       const FeatureSigmas& sigmas_px) noexcept;

[[nodiscard]] FactorSettings make_factor_settings(const BackendConfig& config,
                                                  const RigCalibration& rig) noexcept;

/// Gain that makes a Cauchy-weighted cost as informative as its estimate really is when
/// the noise is Gaussian. With w = 1/(1 + s/c^2), s ~ chi^2 of 2 dof, E over s:
///   gain = E[w^2]^2 / (E[w^2 s / 2] E[w]),
/// since the M-estimate has covariance E[psi psi^T] / E[psi']^2, E[psi'] = E[w^2] and
/// E[psi psi^T] = E[w^2 s / 2], while the weighted normal equations claim 1 / E[w].
/// 1 for c -> infinity. Ours.
[[nodiscard]] double robust_gain(double robust_scale) noexcept;

/// Weight of one sighting with squared residual s: 1 / (1 + s / c^2).
[[nodiscard]] inline double cauchy_weight(double squared, double scale) noexcept {
  return 1.0 / (1.0 + squared / (scale * scale));
}

/// Frames of a sighting at the estimate, or where Jacobians are taken.
[[nodiscard]] PointFrames point_frames(const SlidingWindow& window, const RigCalibration& rig,
                                       const Observation& anchor, const Observation& seen,
                                       bool first_estimates) noexcept;

/// Residual of one of the landmark's sightings (a reference into its list) at the estimate, in
/// sigmas; Jacobians at the first estimates of states that have one. False when behind the camera.
bool evaluate_point(const SlidingWindow& window, const RigCalibration& rig,
                    const FactorSettings& settings, const Landmark& landmark,
                    const Observation& seen, Eigen::Vector2d& residual,
                    PointJacobians* jacobians) noexcept;

/// The same of one of a line's sightings. False when it has no picture there.
bool evaluate_line(const SlidingWindow& window, const RigCalibration& rig,
                   const FactorSettings& settings, const LineLandmark& line,
                   const LineObservation& seen, Eigen::Vector2d& residual,
                   LineJacobians* jacobians) noexcept;

/// Whitened inertial residual (15) between states; Jacobians at their linearisations.
void evaluate_imu(const Preintegration& preintegration, const NavState& i, const NavState& j,
                  const NavState& linearised_i, const NavState& linearised_j, Vector15d& residual,
                  Matrix15d* d_r_d_i, Matrix15d* d_r_d_j) noexcept;

/// Whitened belief about one state (15).
void evaluate_state_prior(const StatePrior& prior, const NavState& x, const NavState& linearised,
                          Vector15d& residual, Matrix15d* d_r_d_x) noexcept;

/// Two states at the same place (6): R_i^T (p_j - p_i) and Log(R_i^T R_j), whitened.
/// @param share  of the information, 0 ... 1.
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
void evaluate_same_place(const FactorSettings& settings, double share, const NavState& i,
                         const NavState& j, const NavState& linearised_i,
                         const NavState& linearised_j, Vector6d& residual, Matrix6d* d_r_d_i,
                         Matrix6d* d_r_d_j) noexcept;

/// Belief about the refined extrinsic (6), whitened: [t - t0; Log(R0^T R)].
[[nodiscard]] Vector6d extrinsic_change(const Pose& from, const Pose& to) noexcept;

/// dx (its rows used by the prior filled) of the states from their first estimates, and
/// r = r0 + J dx. Sizes: prior.r0.
void evaluate_marginal_prior(const SlidingWindow& window, PriorVector& residual) noexcept;

}  // namespace pled
