#include "pled_vins/backend/ceres_solver.hpp"

#include <array>
#include <memory>
#include <vector>

#include <ceres/ceres.h>

#include "src/backend/solver/cost_functions.hpp"

namespace pled {
namespace {

namespace view = ceres_view;

class CeresSolver final : public WindowSolver {
 public:
  SolveSummary solve(const WindowProblem& problem, const SolveOptions& options) noexcept override;

 private:
  void read_window(const SlidingWindow& window);
  void write_window(SlidingWindow& window, const FactorSettings& settings) const;
  void add_parameters(const WindowProblem& p, ceres::Problem& out);
  void add_states(const WindowProblem& p, ceres::Problem& out);
  void add_prior(const WindowProblem& p, ceres::Problem& out);
  void add_points(const WindowProblem& p, ceres::Problem& out);

  static constexpr std::size_t kStates = limits::kWindowStates;
  std::array<std::array<double, view::kPoseSize>, kStates> poses_{};
  std::array<std::array<double, kMotionDim>, kStates> motions_{};
  std::array<std::array<double, view::kPointSize>, limits::kMaxPoints> points_{};
  std::array<double, view::kPoseSize> extrinsic_{};
  double time_shift_s_ = 0;
  std::size_t num_points_ = 0;

  view::PoseManifold pose_manifold_;
  std::array<view::ImuCost, kStates> imu_costs_;
  std::array<view::StatePriorCost, kStates> state_costs_;
  std::array<view::StillCost, kStates> still_costs_;
  std::array<view::SamePlaceCost, kStates> same_place_costs_;
  std::array<view::DepthCost, limits::kMaxPoints> depth_costs_;
  std::array<view::AnchorCost, limits::kMaxPoints> anchor_costs_;
  std::vector<view::PointCost> point_costs_ =
      std::vector<view::PointCost>(limits::kMaxPoints * (kStates - 1));
  std::unique_ptr<ceres::LossFunction> loss_;
  view::MarginalCost marginal_cost_;
  view::ExtrinsicCost extrinsic_cost_;
  view::ScalarCost time_shift_cost_;
};

void CeresSolver::read_window(const SlidingWindow& window) {
  for (std::size_t i = 0; i < window.size(); ++i) {
    view::write_pose(window.state(i).x.T_world_body(), poses_[i].data());
    view::write_motion(window.state(i).x, motions_[i].data());
  }
  view::write_pose(window.rig_state.T_body_cam, extrinsic_.data());
  time_shift_s_ = window.rig_state.time_shift_s;
  num_points_ = 0;
  for (const Landmark& landmark : window.landmarks)
    if (landmark.in_solver && num_points_ < points_.size())
      points_[num_points_++] = landmark.bearing_depth;
}

void CeresSolver::write_window(SlidingWindow& window, const FactorSettings& settings) const {
  for (std::size_t i = 0; i < window.size(); ++i) {
    const Timestamp t = window.state(i).x.t;
    window.state(i).x = view::read_state(poses_[i].data(), motions_[i].data());
    window.state(i).x.q_wb.normalize();
    window.state(i).x.t = t;
  }
  if (settings.estimate_extrinsic) window.rig_state.T_body_cam = view::read_pose(extrinsic_.data());
  if (settings.estimate_time_shift) window.rig_state.time_shift_s = time_shift_s_;
  std::size_t k = 0;
  for (Landmark& landmark : window.landmarks)
    if (landmark.in_solver && k < num_points_) landmark.bearing_depth = points_[k++];
}

void CeresSolver::add_parameters(const WindowProblem& p, ceres::Problem& out) {
  for (std::size_t i = 0; i < p.window.size(); ++i) {
    out.AddParameterBlock(poses_[i].data(), view::kPoseSize, &pose_manifold_);
    out.AddParameterBlock(motions_[i].data(), kMotionDim);
  }
  if (p.settings.estimate_extrinsic)
    out.AddParameterBlock(extrinsic_.data(), view::kPoseSize, &pose_manifold_);
  if (p.settings.estimate_time_shift) out.AddParameterBlock(&time_shift_s_, 1);
}

void CeresSolver::add_states(const WindowProblem& p, ceres::Problem& out) {
  for (std::size_t i = 0; i < p.window.size(); ++i) {
    const WindowState& s = p.window.state(i);
    if (s.has_imu && i > 0) {
      imu_costs_[i].set(p, i);
      out.AddResidualBlock(&imu_costs_[i], nullptr, poses_[i - 1].data(), motions_[i - 1].data(),
                           poses_[i].data(), motions_[i].data());
    }
    if (s.prior) {
      state_costs_[i].set(p, i);
      out.AddResidualBlock(&state_costs_[i], nullptr, poses_[i].data(), motions_[i].data());
    }
    if (s.still) {
      still_costs_[i].set(p, i);
      out.AddResidualBlock(&still_costs_[i], nullptr, motions_[i].data());
    }
    if (s.still_as >= 0) {
      const auto as = static_cast<std::size_t>(s.still_as);
      same_place_costs_[i].set(p, as, i);
      out.AddResidualBlock(&same_place_costs_[i], nullptr, poses_[as].data(), poses_[i].data());
    }
  }
  if (p.settings.estimate_extrinsic) {
    extrinsic_cost_.set(p);
    out.AddResidualBlock(&extrinsic_cost_, nullptr, extrinsic_.data());
  }
  if (p.settings.estimate_time_shift) {
    time_shift_cost_.set(0.0, p.settings.time_shift_sigma_s);
    out.AddResidualBlock(&time_shift_cost_, nullptr, &time_shift_s_);
  }
}

void CeresSolver::add_prior(const WindowProblem& p, ceres::Problem& out) {
  const MarginalPrior& prior = p.window.prior;
  if (!prior.valid) return;
  std::vector<double*> blocks;
  for (std::size_t i = 0; i < p.window.size(); ++i) {
    if (prior.pose_column[i] >= 0) blocks.push_back(poses_[i].data());
    if (prior.motion_column[i] >= 0) blocks.push_back(motions_[i].data());
  }
  if (prior.extrinsic_column >= 0) blocks.push_back(extrinsic_.data());
  if (prior.time_shift_column >= 0) blocks.push_back(&time_shift_s_);
  marginal_cost_.set(p);
  out.AddResidualBlock(&marginal_cost_, nullptr, blocks);
}

void CeresSolver::add_points(const WindowProblem& p, ceres::Problem& out) {
  std::size_t point = 0, cost = 0;
  std::vector<double*> blocks;
  for (const Landmark& landmark : p.window.landmarks) {
    if (!landmark.in_solver || point == num_points_) continue;
    double* block = points_[point].data();
    view::AnchorCost& own = anchor_costs_[point];
    own.set(p, landmark.observations[0]);
    blocks = {block};
    if (p.settings.estimate_time_shift) blocks.push_back(&time_shift_s_);
    out.AddResidualBlock(&own, loss_.get(), blocks);
    for (std::size_t k = 1; k < landmark.observations.size(); ++k) {
      const Observation& seen = landmark.observations[k];
      view::PointCost& f = point_costs_[cost++];
      f.set(p, landmark, seen);
      blocks = {poses_[landmark.observations[0].state].data(), poses_[seen.state].data(), block};
      if (p.settings.estimate_extrinsic) blocks.push_back(extrinsic_.data());
      if (p.settings.estimate_time_shift) blocks.push_back(&time_shift_s_);
      out.AddResidualBlock(&f, loss_.get(), blocks);
    }
    if (landmark.weak_depth) {
      depth_costs_[point].set(landmark.prior_inverse_depth_pm, p.settings.depth_sigma_pm);
      out.AddResidualBlock(&depth_costs_[point], nullptr, block);
    }
    ++point;
  }
}

SolveSummary CeresSolver::solve(const WindowProblem& p, const SolveOptions& options) noexcept {
  SolveSummary out;
  if (p.window.size() == 0) return out;
  read_window(p.window);
  loss_ = std::make_unique<ceres::ScaledLoss>(new ceres::CauchyLoss(p.settings.robust_scale),
                                              p.settings.point_gain, ceres::TAKE_OWNERSHIP);
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.disable_all_safety_checks = true;
  ceres::Problem problem(ownership);
  add_parameters(p, problem);
  add_states(p, problem);
  add_prior(p, problem);
  add_points(p, problem);

  ceres::Solver::Options o;
  o.linear_solver_type = num_points_ > 0 ? ceres::DENSE_SCHUR : ceres::DENSE_NORMAL_CHOLESKY;
  o.dense_linear_algebra_library_type = ceres::EIGEN;
  o.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  o.max_num_iterations = options.max_iterations;
  o.max_solver_time_in_seconds = 1e9;  // iterations bound the work, never the clock
  // Scale lies in a long flat valley: little damping and a fine end, else it is left half way.
  o.initial_trust_region_radius = 1e6;
  o.function_tolerance = 1e-5;
  o.parameter_tolerance = 1e-9;
  o.num_threads = 1;
  o.jacobi_scaling = true;
  o.logging_type = ceres::SILENT;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t k = 0; k < num_points_; ++k) ordering->AddElementToGroup(points_[k].data(), 0);
  const auto later = [&](double* block) {
    if (problem.HasParameterBlock(block)) ordering->AddElementToGroup(block, 1);
  };
  for (std::size_t i = 0; i < p.window.size(); ++i) {
    later(poses_[i].data());
    later(motions_[i].data());
  }
  later(extrinsic_.data());
  later(&time_shift_s_);
  o.linear_solver_ordering = ordering;
  ceres::Solver::Summary summary;
  ceres::Solve(o, &problem, &summary);
  // The first entry is the start itself.
  out.iterations = static_cast<int>(summary.iterations.size()) - 1;
  out.initial_cost = summary.initial_cost;
  out.final_cost = summary.final_cost;
  out.ok = summary.IsSolutionUsable();
  if (out.ok) write_window(p.window, p.settings);
  return out;
}

}  // namespace

std::unique_ptr<WindowSolver> make_ceres_solver() { return std::make_unique<CeresSolver>(); }

}  // namespace pled
