#pragma once

#include "pled_vins/backend/factors.hpp"
#include "pled_vins/backend/window.hpp"

namespace pled {

/// What is to be minimised: every factor of the window, over its states, the points and lines that
/// are `in_solver` (at least two sightings each) with their weights, and the calibration that is
/// refined.
struct WindowProblem {
  SlidingWindow& window;
  const RigCalibration& rig;
  const FactorSettings& settings;
};

struct SolveOptions {
  int max_iterations = 8;     ///< the only bound: never wall-clock time
  bool hold_weights = false;  ///< of points and lines, as they are
};

struct SolveSummary {
  int iterations = 0;
  double initial_cost = 0.0;  ///< half the sum of squares, robust
  double final_cost = 0.0;
  bool ok = false;  ///< false: the window is unchanged
};

/// Moves a window to its optimum.
class WindowSolver {
 public:
  virtual ~WindowSolver() = default;
  virtual SolveSummary solve(const WindowProblem& problem,
                             const SolveOptions& options) noexcept = 0;
};

}  // namespace pled
