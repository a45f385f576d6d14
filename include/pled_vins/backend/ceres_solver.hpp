#pragma once

#include <memory>

#include "pled_vins/backend/window_solver.hpp"

namespace pled {

/// A solver on Ceres: one thread, dense Schur complement, Levenberg-Marquardt. Allocates
/// in every call; all of Ceres' memory is confined to it.
[[nodiscard]] std::unique_ptr<WindowSolver> make_ceres_solver();

}  // namespace pled
