#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "pled_vins/backend/normal_equations.hpp"
#include "pled_vins/backend/window_solver.hpp"

namespace pled {

/// Levenberg-Marquardt on a window: points and lines are eliminated by Schur's complement, and
/// weights are at their minimum for the states of every step, so that they and the states come to
/// the optimum together.
///
/// Some MB, all inside: keep it in static or heap storage. Allocates nothing. Same window, same
/// bits.
class FixedSolver final : public WindowSolver {
 public:
  SolveSummary solve(const WindowProblem& problem, const SolveOptions& options) noexcept override;

 private:
  /// The numbers that a step changes.
  struct Estimate {
    std::array<NavState, limits::kWindowStates> states;
    std::array<std::array<double, kPointDim>, limits::kMaxPoints> points;
    std::array<OrthonormalLine, limits::kMaxLines> lines;
    Pose T_body_cam;
    double time_shift_s = 0.0;
  };

  [[nodiscard]] bool pick(const WindowProblem& p) noexcept;
  [[nodiscard]] double linearise(const WindowProblem& p) noexcept;
  [[nodiscard]] double add_landmarks(const WindowProblem& p) noexcept;
  /// @returns the decrease that the equations promise; 0 when they cannot be solved
  [[nodiscard]] double find_step(double damping) noexcept;
  template <int N>
  [[nodiscard]] double finish_landmark(const LandmarkBlocks<N>& blocks,
                                       const Eigen::Matrix<double, N, N>& h_inverse, double damping,
                                       Eigen::Matrix<double, N, 1>& step) const noexcept;
  void keep(const WindowProblem& p) noexcept;
  void take_step(const WindowProblem& p) const noexcept;
  void take_back(const WindowProblem& p) const noexcept;

  NormalEquations equations_;
  PriorMatrix H_;  ///< damped, landmarks eliminated
  PriorVector b_;
  PriorVector step_;
  std::array<std::size_t, limits::kMaxPoints> point_index_{};  ///< in the window
  std::array<std::size_t, limits::kMaxLines> line_index_{};
  std::size_t num_points_ = 0;
  std::size_t num_lines_ = 0;
  bool hold_weights_ = false;
  std::array<PointBlocks, limits::kMaxPoints> points_;
  std::array<LineBlocks, limits::kMaxLines> lines_;
  std::array<Eigen::Matrix<double, kPointDim, kPointDim>, limits::kMaxPoints> point_inverse_;
  std::array<Eigen::Matrix<double, kLineDim, kLineDim>, limits::kMaxLines> line_inverse_;
  std::array<Eigen::Matrix<double, kPointDim, 1>, limits::kMaxPoints> point_step_;
  std::array<Eigen::Matrix<double, kLineDim, 1>, limits::kMaxLines> line_step_;
  PointSights point_sights_;
  LineSights line_sights_;
  Estimate kept_;
};

}  // namespace pled
