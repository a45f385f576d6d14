#pragma once

#include "pled_vins/backend/landmark_book.hpp"
#include "pled_vins/backend/normal_equations.hpp"
#include "pled_vins/backend/start.hpp"
#include "pled_vins/backend/window_solver.hpp"

namespace pled {

/// What is known before a start: biases from an earlier life of the estimator, or zero.
struct StartBelief {
  Eigen::Vector3d bg = Eigen::Vector3d::Zero();
  Eigen::Vector3d ba = Eigen::Vector3d::Zero();
  double bg_sigma_radps = 0.05;
  double ba_sigma_mps2 = 0.1;
};

/// Prior of a first state: position and yaw are chosen, hence nearly exact; the rest is loose.
[[nodiscard]] StatePrior gauge_prior(const NavState& mean, const StartBelief& belief) noexcept;

/// Collects frames until motion, or standing, tells the first states; then fills the window.
class Bootstrap {
 public:
  Bootstrap(const BackendConfig& config, const RigCalibration& rig, const ImuNoise& noise,
            const FactorSettings& settings) noexcept
      : config_(config), rig_(rig), noise_(noise), settings_(settings) {}

  void clear() noexcept { frames_.clear(); }

  /// Takes one more frame and tries to start. kNone: the window holds up to limits::kWindowStates
  /// solved states, the newest that of `frame`. Otherwise the window is empty.
  StartRefusal attempt(const FrameMeasurement& frame, const ImuHistory& imu,
                       const StartBelief& belief, LandmarkBook& book, WindowSolver& solver,
                       SlidingWindow& window) noexcept;

  /// The figure that the last refusal was judged by.
  [[nodiscard]] double detail() const noexcept { return detail_; }

 private:
  void collect(const FrameMeasurement& frame) noexcept;
  [[nodiscard]] bool fill(const StartGuess& guess, const ImuHistory& imu, const StartBelief& belief,
                          const LandmarkBook& book, SlidingWindow& window) noexcept;
  [[nodiscard]] StartRefusal refine(const StartBelief& belief, bool stationary, LandmarkBook& book,
                                    WindowSolver& solver, SlidingWindow& window) noexcept;
  /// Relative sigma of the distance travelled from the first to the newest state.
  [[nodiscard]] double scale_sigma(const SlidingWindow& window) noexcept;

  const BackendConfig& config_;
  const RigCalibration& rig_;
  const ImuNoise& noise_;
  const FactorSettings& settings_;
  StartFrames frames_;
  FrameMeasurement agreed_;  ///< one frame, reduced to the points that agree with the guess
  NormalEquations equations_;
  double detail_ = 0;
};

}  // namespace pled
