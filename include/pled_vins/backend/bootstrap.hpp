#pragma once

#include <array>

#include "pled_vins/backend/landmark_book.hpp"
#include "pled_vins/backend/start.hpp"
#include "pled_vins/backend/window_solver.hpp"

namespace pled {

/// Prior of a first state: position and yaw are chosen, hence nearly exact; the rest is loose.
[[nodiscard]] StatePrior gauge_prior(const NavState& mean, const StartBelief& belief) noexcept;

/// Collects frames until motion, or standing, tells the first states; then fills the window.
class Bootstrap {
 public:
  Bootstrap(const BackendConfig& config, const RigCalibration& rig, const ImuNoise& noise,
            const FactorSettings& settings) noexcept
      : config_(config), rig_(rig), noise_(noise), settings_(settings) {}

  void clear() noexcept;

  /// Takes one more frame and tries to start; a motion must be found twice, a tenth of a second
  /// apart. Of frames at a higher rate than can be kept, only those that stay are tried. kNone: the
  /// window holds fewer than limits::kWindowStates states, solved, the newest that of `frame`.
  /// Otherwise the window is empty.
  StartRefusal attempt(const FrameMeasurement& frame, const ImuHistory& imu,
                       const StartBelief& belief, LandmarkBook& book, WindowSolver& solver,
                       SlidingWindow& window) noexcept;

  /// The figure that the last refusal was judged by.
  [[nodiscard]] double detail() const noexcept { return detail_; }

 private:
  void collect(const FrameMeasurement& frame) noexcept;
  void thin() noexcept;
  [[nodiscard]] bool fill(const StartGuess& guess, const ImuHistory& imu, const StartBelief& belief,
                          const LandmarkBook& book, SlidingWindow& window) noexcept;
  [[nodiscard]] StartRefusal refine(const StartBelief& belief, bool stationary, LandmarkBook& book,
                                    WindowSolver& solver, SlidingWindow& window) noexcept;
  [[nodiscard]] StartRefusal start(const ImuHistory& imu, const StartBelief& belief,
                                   LandmarkBook& book, WindowSolver& solver,
                                   SlidingWindow& window) noexcept;
  /// The newest frame is far enough from the one before to be kept.
  [[nodiscard]] bool spaced() const noexcept;
  /// True when the guess agrees with one of a little earlier: same velocity and same vertical at
  /// the earlier one's time. Remembers the guess.
  [[nodiscard]] bool confirmed(const StartGuess& guess) noexcept;
  [[nodiscard]] double accepted_scale_sigma() const noexcept;
  [[nodiscard]] static double agreeing_share(const SlidingWindow& window) noexcept;
  [[nodiscard]] static double scale_change(const StartGuess& guess,
                                           const SlidingWindow& window) noexcept;

  const BackendConfig& config_;
  const RigCalibration& rig_;
  const ImuNoise& noise_;
  const FactorSettings& settings_;
  StartFrames frames_;
  FrameMeasurement agreed_;        ///< one frame, reduced to the points that agree with the guess
  std::array<NavState, 8> found_;  ///< newest states of earlier guesses, oldest first
  std::size_t num_found_ = 0;
  Timestamp collecting_since_;
  StartRefusal last_refusal_ = StartRefusal::kTooFewFrames;
  double detail_ = 0;
};

}  // namespace pled
