#pragma once

#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/sized_cost_function.h>

#include "pled_vins/backend/factors.hpp"
#include "pled_vins/backend/window_solver.hpp"

/// Ceres' view of the factors: residuals and Jacobians come from the same functions as in
/// marginalisation, at the states that Ceres tries. Jacobians by a pose (7 numbers) hold the
/// tangent's in the first 6 columns and 0 in the last; PoseManifold's Plus Jacobian is [I; 0] to
/// match.
namespace pled::ceres_view {

inline constexpr int kPoseSize = 7;   ///< p, then q as x y z w
inline constexpr int kPointSize = 3;  ///< bearing x, y; inverse depth
inline constexpr int kLineSize = 5;   ///< U as x y z w, phi

template <int kRows>
using PoseJacobian = Eigen::Matrix<double, kRows, kPoseSize, Eigen::RowMajor>;
template <int kRows>
using MotionJacobian = Eigen::Matrix<double, kRows, kMotionDim, Eigen::RowMajor>;

class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseSize; }
  int TangentSize() const override { return kPoseDim; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

/// As PoseManifold: its tangent's 4 columns, then 0.
class LineManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kLineSize; }
  int TangentSize() const override { return 4; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

/// The loss of a sighting at a weight that is held.
class SightLoss final : public ceres::LossFunction {
 public:
  void set(const FactorSettings& settings, double w) {
    settings_ = &settings;
    w_ = w;
  }
  void Evaluate(double squared, double out[3]) const override;

 private:
  const FactorSettings* settings_ = nullptr;
  double w_ = 1.0;
};

/// Where a pose and a motion live in Ceres' arrays.
void write_pose(const Pose& pose, double* out);
[[nodiscard]] Pose read_pose(const double* in);
void write_motion(const NavState& state, double* out);
[[nodiscard]] NavState read_state(const double* pose, const double* motion);
void write_line(const OrthonormalLine& line, double* out);
[[nodiscard]] OrthonormalLine read_line(const double* in);

/// Blocks: pose i, pose j, point[, extrinsic][, time shift].
class PointCost final : public ceres::CostFunction {
 public:
  void set(const WindowProblem& problem, const Landmark& landmark, const Observation& seen);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const WindowProblem* problem_ = nullptr;
  const Observation* anchor_ = nullptr;
  const Observation* seen_ = nullptr;
};

/// The anchor's own sighting. Blocks: point[, time shift].
class AnchorCost final : public ceres::CostFunction {
 public:
  void set(const WindowProblem& problem, const Observation& seen);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const WindowProblem* problem_ = nullptr;
  const Observation* seen_ = nullptr;
};

/// Blocks: pose, line[, extrinsic][, time shift].
class LineCost final : public ceres::CostFunction {
 public:
  void set(const WindowProblem& problem, const LineLandmark& line, const LineObservation& seen);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const WindowProblem* problem_ = nullptr;
  const LineLandmark* line_ = nullptr;
  const LineObservation* seen_ = nullptr;
};

/// Belief about an inverse depth. Two rows, the second 0: points keep blocks of two rows, which
/// Ceres has fast code for.
class DepthCost final : public ceres::SizedCostFunction<2, 3> {
 public:
  void set(double mean_pm, double sigma_pm) {
    mean_pm_ = mean_pm;
    weight_ = 1.0 / sigma_pm;
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  double mean_pm_ = 0;
  double weight_ = 0;
};

/// A cost that looks up what it needs of one state, or of none, in the window.
template <int kRows, int... kBlocks>
class StateCost : public ceres::SizedCostFunction<kRows, kBlocks...> {
 public:
  void set(const WindowProblem& problem, std::size_t state = 0) {
    problem_ = &problem;
    state_ = state;
  }

 protected:
  const WindowProblem* problem_ = nullptr;
  std::size_t state_ = 0;
};

/// The interval before a state. Blocks: pose i, motion i, pose j, motion j (the state).
class ImuCost final : public StateCost<15, 7, 9, 7, 9> {
 public:
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;
};

/// Blocks: pose, motion.
class StatePriorCost final : public StateCost<15, 7, 9> {
 public:
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;
};

/// v = 0. Block: motion.
class StillCost final : public StateCost<3, 9> {
 public:
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;
};

/// Block: extrinsic.
class ExtrinsicCost final : public StateCost<6, 7> {
 public:
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;
};

/// Blocks: pose i, pose j.
class SamePlaceCost final : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  void set(const WindowProblem& problem, std::size_t from, std::size_t to) {
    problem_ = &problem;
    from_ = from;
    to_ = to;
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const WindowProblem* problem_ = nullptr;
  std::size_t from_ = 0;
  std::size_t to_ = 0;
};

/// A belief about one number.
class ScalarCost final : public ceres::SizedCostFunction<1, 1> {
 public:
  void set(double mean, double sigma) {
    mean_ = mean;
    weight_ = 1.0 / sigma;
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  double mean_ = 0;
  double weight_ = 0;
};

/// Blocks: every block the prior touches, by state (pose before motion), then extrinsic, shift.
class MarginalCost final : public ceres::CostFunction {
 public:
  void set(const WindowProblem& problem);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  struct Block {
    int column = 0;
    int state = -1;  ///< -1: calibration
    int size = 0;    ///< tangent: 6 pose or extrinsic, 9 motion, 1 shift
  };
  const WindowProblem* problem_ = nullptr;
  FixedVector<Block, 2 * limits::kWindowStates + 2> blocks_;
};

}  // namespace pled::ceres_view
