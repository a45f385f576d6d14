#pragma once

#include <memory>

#include "pled_vins/backend/window_solver.hpp"

namespace pled {

/// See SolverKind::kCeres.
[[nodiscard]] std::unique_ptr<WindowSolver> make_ceres_solver();

}  // namespace pled
