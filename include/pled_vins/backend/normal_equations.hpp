#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "pled_vins/backend/factors.hpp"
#include "pled_vins/backend/window.hpp"

namespace pled {

/// Gauss-Newton equations H dx = -b of the window's states and refined calibration with the
/// points eliminated: 15 per state, then extrinsic (6) and time shift (1) when refined.
/// Robust weights are those at the estimate, held constant.
class NormalEquations {
 public:
  /// Empty equations of the window's size.
  void reset(const SlidingWindow& window, const FactorSettings& settings) noexcept;

  /// Every factor of the window once; points that are in the solver.
  void add_all(const SlidingWindow& window, const RigCalibration& rig,
               const FactorSettings& settings) noexcept;

  /// Inertial factor that leads to state i, if there is one.
  void add_imu(const SlidingWindow& window, std::size_t i, const FactorSettings& settings) noexcept;
  /// Prior and standstill factor (v = 0) of state i alone.
  void add_state(const SlidingWindow& window, std::size_t i,
                 const FactorSettings& settings) noexcept;
  /// "Same place as" factor of state i, if there is one.
  void add_same_place(const SlidingWindow& window, std::size_t i,
                      const FactorSettings& settings) noexcept;
  void add_marginal_prior(const SlidingWindow& window) noexcept;
  /// Beliefs about refined calibration.
  void add_calibration_prior(const SlidingWindow& window, const FactorSettings& settings) noexcept;
  /// The first `count` sightings of a point, its depth eliminated.
  void add_point(const SlidingWindow& window, const RigCalibration& rig,
                 const FactorSettings& settings, const Landmark& landmark,
                 std::size_t count) noexcept;

  [[nodiscard]] int dim() const noexcept { return dim_; }
  [[nodiscard]] int extrinsic_row() const noexcept { return extrinsic_row_; }  ///< -1: not refined
  [[nodiscard]] int time_shift_row() const noexcept {
    return time_shift_row_;
  }  ///< -1: not refined
  [[nodiscard]] PriorMatrix& H() noexcept { return H_; }
  [[nodiscard]] PriorVector& b() noexcept { return b_; }

 private:
  int dim_ = 0;
  int extrinsic_row_ = -1;
  int time_shift_row_ = -1;
  PriorMatrix H_;
  PriorVector b_;
  /// d^2 cost / d state d point of the point being added.
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxWindowDim, 3> W_;
  PriorVector prior_residual_;
  PriorMatrix prior_H_;
};

}  // namespace pled
