#include "src/backend/solver/ceres_solver.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include <ceres/ceres.h>

#include "pled_vins/backend/feature_loss.hpp"
#include "pled_vins/backend/sights.hpp"
#include "src/backend/solver/cost_functions.hpp"

namespace pled {
namespace {

namespace view = ceres_view;

constexpr int kIterationsATurn = 4;  ///< of states, before weights have theirs

void weigh_all(const WindowProblem& p) {
  for (Landmark& landmark : p.window.landmarks)
    if (landmark.in_solver)
      weigh(p.settings, squared_sights(p.window, p.rig, p.settings, landmark).span(),
            landmark.reliability);
  for (LineLandmark& line : p.window.lines)
    if (line.in_solver)
      weigh(p.settings, squared_sights(p.window, p.rig, p.settings, line).span(), line.reliability);
}

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
  void add_lines(const WindowProblem& p, ceres::Problem& out);
  void order(const WindowProblem& p, const ceres::Problem& problem,
             ceres::ParameterBlockOrdering& out);
  [[nodiscard]] SolveSummary solve_once(const WindowProblem& p, int max_iterations);

  static constexpr std::size_t kStates = limits::kWindowStates;
  std::array<std::array<double, view::kPoseSize>, kStates> poses_{};
  std::array<std::array<double, kMotionDim>, kStates> motions_{};
  std::array<std::array<double, view::kPointSize>, limits::kMaxPoints> points_{};
  std::array<double, view::kPoseSize> extrinsic_{};
  double time_shift_s_ = 0;
  std::size_t num_points_ = 0;
  std::array<std::array<double, view::kLineSize>, limits::kMaxLines> lines_{};
  std::size_t num_lines_ = 0;

  view::PoseManifold pose_manifold_;
  view::LineManifold line_manifold_;
  std::array<view::ImuCost, kStates> imu_costs_;
  std::array<view::StatePriorCost, kStates> state_costs_;
  std::array<view::StillCost, kStates> still_costs_;
  std::array<view::SamePlaceCost, kStates> same_place_costs_;
  std::array<view::DepthCost, limits::kMaxPoints> depth_costs_;
  std::array<view::AnchorCost, limits::kMaxPoints> anchor_costs_;
  std::vector<view::PointCost> point_costs_ =
      std::vector<view::PointCost>(limits::kMaxPoints * (kStates - 1));
  std::array<view::SightLoss, limits::kMaxPoints> point_losses_;
  std::vector<view::LineCost> line_costs_ =
      std::vector<view::LineCost>(limits::kMaxLines * kStates);
  std::array<view::SightLoss, limits::kMaxLines> line_losses_;
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
  num_lines_ = 0;
  for (const LineLandmark& line : window.lines)
    if (line.in_solver && num_lines_ < lines_.size())
      view::write_line(line.line(), lines_[num_lines_++].data());
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
  k = 0;
  for (LineLandmark& line : window.lines)
    if (line.in_solver && k < num_lines_) line.set_line(view::read_line(lines_[k++].data()));
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
    view::SightLoss* loss = &point_losses_[point];
    loss->set(p.settings, landmark.reliability.w);
    blocks = {block};
    if (p.settings.estimate_time_shift) blocks.push_back(&time_shift_s_);
    out.AddResidualBlock(&own, loss, blocks);
    for (std::size_t k = 1; k < landmark.observations.size(); ++k) {
      const Observation& seen = landmark.observations[k];
      view::PointCost& f = point_costs_[cost++];
      f.set(p, landmark, seen);
      blocks = {poses_[landmark.observations[0].state].data(), poses_[seen.state].data(), block};
      if (p.settings.estimate_extrinsic) blocks.push_back(extrinsic_.data());
      if (p.settings.estimate_time_shift) blocks.push_back(&time_shift_s_);
      out.AddResidualBlock(&f, loss, blocks);
    }
    if (landmark.weak_depth) {
      depth_costs_[point].set(landmark.prior_inverse_depth_pm, p.settings.depth_sigma_pm);
      out.AddResidualBlock(&depth_costs_[point], nullptr, block);
    }
    ++point;
  }
}

void CeresSolver::add_lines(const WindowProblem& p, ceres::Problem& out) {
  std::size_t index = 0, cost = 0;
  std::vector<double*> blocks;
  for (const LineLandmark& line : p.window.lines) {
    if (!line.in_solver || index == num_lines_) continue;
    double* block = lines_[index].data();
    view::SightLoss& loss = line_losses_[index++];
    loss.set(p.settings, line.reliability.w);
    out.AddParameterBlock(block, view::kLineSize, &line_manifold_);
    for (const LineObservation& seen : line.observations) {
      view::LineCost& f = line_costs_[cost++];
      f.set(p, line, seen);
      blocks = {poses_[seen.state].data(), block};
      if (p.settings.estimate_extrinsic) blocks.push_back(extrinsic_.data());
      if (p.settings.estimate_time_shift) blocks.push_back(&time_shift_s_);
      out.AddResidualBlock(&f, &loss, blocks);
    }
  }
}

void CeresSolver::order(const WindowProblem& p, const ceres::Problem& problem,
                        ceres::ParameterBlockOrdering& out) {
  for (std::size_t k = 0; k < num_points_; ++k) out.AddElementToGroup(points_[k].data(), 0);
  for (std::size_t k = 0; k < num_lines_; ++k) out.AddElementToGroup(lines_[k].data(), 0);
  const auto later = [&](double* block) {
    if (problem.HasParameterBlock(block)) out.AddElementToGroup(block, 1);
  };
  for (std::size_t i = 0; i < p.window.size(); ++i) {
    later(poses_[i].data());
    later(motions_[i].data());
  }
  later(extrinsic_.data());
  later(&time_shift_s_);
}

SolveSummary CeresSolver::solve_once(const WindowProblem& p, int max_iterations) {
  read_window(p.window);
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
  add_lines(p, problem);

  ceres::Solver::Options o;
  o.linear_solver_type =
      num_points_ + num_lines_ > 0 ? ceres::DENSE_SCHUR : ceres::DENSE_NORMAL_CHOLESKY;
  o.dense_linear_algebra_library_type = ceres::EIGEN;
  o.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  o.max_num_iterations = max_iterations;
  o.max_solver_time_in_seconds = 1e9;  // iterations bound the work, never the clock
  // Scale lies in a long flat valley: little damping and a fine end, else it is left half way.
  o.initial_trust_region_radius = 1e6;
  o.function_tolerance = 1e-5;
  o.parameter_tolerance = 1e-9;
  o.num_threads = 1;
  o.jacobi_scaling = true;
  o.logging_type = ceres::SILENT;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  order(p, problem, *ordering);
  o.linear_solver_ordering = ordering;
  ceres::Solver::Summary summary;
  ceres::Solve(o, &problem, &summary);
  SolveSummary out;
  // The first entry is the start itself.
  out.iterations = static_cast<int>(summary.iterations.size()) - 1;
  out.initial_cost = summary.initial_cost;
  out.final_cost = summary.final_cost;
  out.ok = summary.IsSolutionUsable();
  if (out.ok) write_window(p.window, p.settings);
  return out;
}

SolveSummary CeresSolver::solve(const WindowProblem& p, const SolveOptions& options) noexcept {
  SolveSummary out;
  if (p.window.size() == 0) return out;
  if (options.hold_weights) return solve_once(p, options.max_iterations);
  // Weights and states in turn, as DynaVINS has it.
  for (int left = options.max_iterations; left > 0;) {
    weigh_all(p);
    const SolveSummary part = solve_once(p, std::min(left, kIterationsATurn));
    if (!part.ok) return part;
    if (out.iterations == 0) out.initial_cost = part.initial_cost;
    out.final_cost = part.final_cost;
    out.iterations += part.iterations;
    out.ok = true;
    if (part.iterations < kIterationsATurn) break;
    left -= part.iterations;
  }
  return out;
}

}  // namespace

std::unique_ptr<WindowSolver> make_ceres_solver() { return std::make_unique<CeresSolver>(); }

}  // namespace pled
