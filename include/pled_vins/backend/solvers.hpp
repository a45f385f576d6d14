#pragma once

#include <cstdint>
#include <memory>

#include "pled_vins/backend/window_solver.hpp"

namespace pled {

/// What moves a window to its optimum.
enum class SolverKind : std::uint8_t {
  kFixed,  ///< FixedSolver: ours, all its memory inside
  /// Ceres, one thread, dense Schur complement, Levenberg-Marquardt, weights in turn with states:
  /// the reference. Allocates in every call; all of Ceres' memory is confined to it.
  kCeres,
};

[[nodiscard]] std::unique_ptr<WindowSolver> make_solver(SolverKind kind);

}  // namespace pled
