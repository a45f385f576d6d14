#pragma once

#include <cstdint>
#include <memory>

#include <Eigen/Core>

#include "pled_vins/backend/normal_equations.hpp"
#include "pled_vins/backend/window.hpp"
#include "pled_vins/geometry/camera.hpp"

namespace pled::support {

/// A full window of a drone's flight, before anything was marginalised, without the belief
/// about its first state: nothing fixes position and heading.
struct FreeWindow {
  FreeWindow();
  std::unique_ptr<SlidingWindow> window;
  RigCalibration rig;
  FactorSettings settings;
};

/// The same with its first state held.
struct GaugedWindow : FreeWindow {
  GaugedWindow();
};

/// Lines in space, seen by every state that has them before its camera, with the settings' noise;
/// triangulated, in the solver.
void add_lines(FreeWindow& f, std::size_t count, std::uint64_t seed);

/// The four directions that no measurement tells: three shifts and a turn about gravity, at the
/// states' linearisation points.
[[nodiscard]] Eigen::MatrixXd null_space(const SlidingWindow& window, int dim,
                                         bool first_estimates);

/// How much the equations claim to know along each direction, against what they know in all.
[[nodiscard]] double leak(NormalEquations& equations, const Eigen::MatrixXd& N);

/// Moves states by up to 2 cm, 1 degree and 2 cm/s, and a little in the biases.
void disturb(SlidingWindow& window, std::uint64_t seed);

}  // namespace pled::support
