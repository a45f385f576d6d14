#include "pled_vins/backend/solvers.hpp"

#include "pled_vins/backend/fixed_solver.hpp"
#include "src/backend/solver/ceres_solver.hpp"

namespace pled {

std::unique_ptr<WindowSolver> make_solver(SolverKind kind) {
  if (kind == SolverKind::kCeres) return make_ceres_solver();
  return std::make_unique<FixedSolver>();
}

}  // namespace pled
