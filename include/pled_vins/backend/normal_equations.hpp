#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "pled_vins/backend/factors.hpp"
#include "pled_vins/backend/sights.hpp"
#include "pled_vins/backend/window.hpp"

namespace pled {

/// Gauss-Newton equations H dx = -b of the window's states and refined calibration with points
/// and lines eliminated: 15 per state, then extrinsic (6) and time shift (1) when refined.
/// Weights are those of the landmarks and of their residuals at the estimate, held constant.
class NormalEquations {
 public:
  /// Empty equations of the window's size.
  void reset(const SlidingWindow& window, const FactorSettings& settings) noexcept;

  /// Every factor of the window once; points and lines that are in the solver.
  void add_all(const SlidingWindow& window, const RigCalibration& rig,
               const FactorSettings& settings) noexcept;

  /// Empty equations, then every factor but those of points and lines.
  void add_states(const SlidingWindow& window, const FactorSettings& settings) noexcept;

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
  /// The first `count` sightings of a point or line, its own numbers eliminated.
  void add_point(const SlidingWindow& window, const RigCalibration& rig,
                 const FactorSettings& settings, const Landmark& landmark,
                 std::size_t count) noexcept;
  void add_line(const SlidingWindow& window, const RigCalibration& rig,
                const FactorSettings& settings, const LineLandmark& line,
                std::size_t count) noexcept;

  /// The same by halves: adds what sightings say of states, and writes what they say of the
  /// landmark to `out`.
  void add_sights(const Landmark& landmark, const RigCalibration& rig,
                  const FactorSettings& settings, const PointSights& sights,
                  PointBlocks& out) noexcept;
  void add_sights(const LineLandmark& line, const RigCalibration& rig,
                  const FactorSettings& settings, const LineSights& sights,
                  LineBlocks& out) noexcept;
  /// Takes a landmark's numbers out of the equations.
  template <int N>
  void eliminate(const LandmarkBlocks<N>& blocks,
                 const Eigen::Matrix<double, N, N>& h_inverse) noexcept {
    eliminate_from(blocks, h_inverse, H_, b_);
  }
  /// The same of a copy of the equations with these sizes.
  template <int N>
  void eliminate_from(const LandmarkBlocks<N>& blocks, const Eigen::Matrix<double, N, N>& h_inverse,
                      PriorMatrix& H, PriorVector& b) const noexcept;
  /// Landmarks are added to the upper triangle of H alone: makes both alike.
  void complete() noexcept;

  /// Half the sum of squares of what was added, landmarks left out.
  [[nodiscard]] double cost() const noexcept { return cost_; }
  [[nodiscard]] int dim() const noexcept { return dim_; }
  [[nodiscard]] int extrinsic_row() const noexcept { return extrinsic_row_; }  ///< -1: not refined
  [[nodiscard]] int time_shift_row() const noexcept {
    return time_shift_row_;
  }  ///< -1: not refined
  [[nodiscard]] PriorMatrix& H() noexcept { return H_; }
  [[nodiscard]] PriorVector& b() noexcept { return b_; }
  [[nodiscard]] const PriorMatrix& H() const noexcept { return H_; }
  [[nodiscard]] const PriorVector& b() const noexcept { return b_; }

 private:
  int dim_ = 0;
  double cost_ = 0.0;
  int extrinsic_row_ = -1;
  int time_shift_row_ = -1;
  PriorMatrix H_;
  PriorVector b_;
  PointSights point_sights_;
  LineSights line_sights_;
  PointBlocks point_blocks_;
  LineBlocks line_blocks_;
  PriorVector prior_residual_;
  PriorMatrix prior_H_;
};

}  // namespace pled
