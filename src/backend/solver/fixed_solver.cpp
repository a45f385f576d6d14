#include "pled_vins/backend/fixed_solver.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "pled_vins/backend/feature_loss.hpp"
#include "pled_vins/geometry/so3.hpp"
#include "src/backend/row_of.hpp"

namespace pled {
namespace {

// Scale lies in a long flat valley: little damping and a fine end, else it is left half way.
constexpr double kFirstDamping = 1e-6;
constexpr double kMostDamping = 1e12;
constexpr double kFineEnd = 1e-5;  ///< relative decrease of the cost
constexpr int kMostRefusals = 5;   ///< on end
/// What is added to the diagonal is at least this share of the damping.
constexpr double kLeastDiagonal = 1e-6;

double damped(double diagonal, double damping) noexcept {
  return damping * std::max(diagonal, kLeastDiagonal);
}

/// Damping after a step that kept `quality` of its promise (Nielsen's rule, as Ceres has it).
double relaxed(double damping, double quality) noexcept {
  const double q = 2.0 * quality - 1.0;
  return damping * std::max(1.0 / 3.0, 1.0 - q * q * q);
}

}  // namespace

bool FixedSolver::pick(const WindowProblem& p) noexcept {
  num_points_ = num_lines_ = 0;
  for (std::size_t i = 0; i < p.window.landmarks.size(); ++i)
    if (p.window.landmarks[i].in_solver && num_points_ < point_index_.size())
      point_index_[num_points_++] = i;
  for (std::size_t i = 0; i < p.window.lines.size(); ++i)
    if (p.window.lines[i].in_solver && num_lines_ < line_index_.size())
      line_index_[num_lines_++] = i;
  return p.window.size() > 0;
}

/// Points and lines, each with its best weight at the states as they are.
double FixedSolver::add_landmarks(const WindowProblem& p) noexcept {
  double cost = 0.0;
  for (std::size_t k = 0; k < num_points_; ++k) {
    Landmark& landmark = p.window.landmarks[point_index_[k]];
    evaluate_sights(p.window, p.rig, p.settings, landmark, landmark.observations.size(),
                    point_sights_);
    if (!hold_weights_) weigh(p.settings, point_sights_.squared(), landmark.reliability);
    cost += feature_cost(p.settings, point_sights_.squared(), landmark.reliability);
    equations_.add_sights(landmark, p.rig, p.settings, point_sights_, points_[k]);
    if (!landmark.weak_depth) continue;
    const double information = 1.0 / (p.settings.depth_sigma_pm * p.settings.depth_sigma_pm);
    const double off_pm = landmark.inverse_depth_pm() - landmark.prior_inverse_depth_pm;
    points_[k].h(2, 2) += information;
    points_[k].g[2] += information * off_pm;
    cost += 0.5 * information * off_pm * off_pm;
  }
  for (std::size_t k = 0; k < num_lines_; ++k) {
    LineLandmark& line = p.window.lines[line_index_[k]];
    evaluate_sights(p.window, p.rig, p.settings, line, line.observations.size(), line_sights_);
    if (!hold_weights_) weigh(p.settings, line_sights_.squared(), line.reliability);
    cost += feature_cost(p.settings, line_sights_.squared(), line.reliability);
    equations_.add_sights(line, p.rig, p.settings, line_sights_, lines_[k]);
  }
  return cost;
}

double FixedSolver::linearise(const WindowProblem& p) noexcept {
  equations_.add_states(p.window, p.settings);
  const double cost = equations_.cost() + add_landmarks(p);
  equations_.complete();
  return cost;
}

template <int N>
double FixedSolver::finish_landmark(const LandmarkBlocks<N>& blocks,
                                    const Eigen::Matrix<double, N, N>& h_inverse, double damping,
                                    Eigen::Matrix<double, N, 1>& step) const noexcept {
  Eigen::Matrix<double, N, 1> g = blocks.g;
  for (std::size_t i = 0; i < blocks.count; ++i)
    g.noalias() += blocks.W[i].transpose() * step_.segment<kPoseDim>(row_of(blocks.states[i]));
  if (equations_.extrinsic_row() >= 0)
    g.noalias() +=
        blocks.W_extrinsic.transpose() * step_.segment<kExtrinsicDim>(equations_.extrinsic_row());
  if (equations_.time_shift_row() >= 0)
    g += blocks.W_time_shift.transpose() * step_[equations_.time_shift_row()];
  step.noalias() = -h_inverse * g;
  double promise = -blocks.g.dot(step);
  for (int i = 0; i < N; ++i) promise += damped(blocks.h(i, i), damping) * step[i] * step[i];
  return 0.5 * promise;
}

double FixedSolver::find_step(double damping) noexcept {
  H_ = equations_.H();
  b_ = equations_.b();
  for (int i = 0; i < equations_.dim(); ++i) H_(i, i) += damped(H_(i, i), damping);
  const auto invert = [damping](const auto& h) {
    auto out = h;
    for (int i = 0; i < h.rows(); ++i) out(i, i) += damped(h(i, i), damping);
    return out.inverse().eval();
  };
  for (std::size_t k = 0; k < num_points_; ++k) {
    point_inverse_[k] = invert(points_[k].h);
    equations_.eliminate_from(points_[k], point_inverse_[k], H_, b_);
  }
  for (std::size_t k = 0; k < num_lines_; ++k) {
    line_inverse_[k] = invert(lines_[k].h);
    equations_.eliminate_from(lines_[k], line_inverse_[k], H_, b_);
  }
  Eigen::LLT<Eigen::Ref<PriorMatrix>, Eigen::Upper> llt(H_);
  if (llt.info() != Eigen::Success) return 0.0;
  step_ = -b_;
  llt.solveInPlace(step_);
  // With (H + D) dx = -b the model falls by (-b dx + dx D dx) / 2.
  double promise = 0.0;
  for (int i = 0; i < equations_.dim(); ++i)
    promise +=
        0.5 * step_[i] * (damped(equations_.H()(i, i), damping) * step_[i] - equations_.b()[i]);
  for (std::size_t k = 0; k < num_points_; ++k)
    promise += finish_landmark(points_[k], point_inverse_[k], damping, point_step_[k]);
  for (std::size_t k = 0; k < num_lines_; ++k)
    promise += finish_landmark(lines_[k], line_inverse_[k], damping, line_step_[k]);
  return promise;
}

void FixedSolver::keep(const WindowProblem& p) noexcept {
  for (std::size_t i = 0; i < p.window.size(); ++i) kept_.states[i] = p.window.state(i).x;
  for (std::size_t k = 0; k < num_points_; ++k)
    kept_.points[k] = p.window.landmarks[point_index_[k]].bearing_depth;
  for (std::size_t k = 0; k < num_lines_; ++k)
    kept_.lines[k] = p.window.lines[line_index_[k]].line();
  kept_.T_body_cam = p.window.rig_state.T_body_cam;
  kept_.time_shift_s = p.window.rig_state.time_shift_s;
}

void FixedSolver::take_step(const WindowProblem& p) const noexcept {
  for (std::size_t i = 0; i < p.window.size(); ++i) {
    NavState& x = p.window.state(i).x;
    const Timestamp t = x.t;
    x = box_plus(x, step_.segment<kStateDim>(row_of(i)));
    x.q_wb.normalize();
    x.t = t;
  }
  for (std::size_t k = 0; k < num_points_; ++k) {
    auto& point = p.window.landmarks[point_index_[k]].bearing_depth;
    for (std::size_t i = 0; i < point.size(); ++i)
      point[i] += point_step_[k][static_cast<Eigen::Index>(i)];
  }
  for (std::size_t k = 0; k < num_lines_; ++k) {
    LineLandmark& line = p.window.lines[line_index_[k]];
    OrthonormalLine moved = box_plus(line.line(), line_step_[k]);
    moved.U.normalize();
    line.set_line(moved);
  }
  RigState& rig = p.window.rig_state;
  if (equations_.extrinsic_row() >= 0) {
    const Vector6d d = step_.segment<kExtrinsicDim>(equations_.extrinsic_row());
    rig.T_body_cam.p += d.head<3>();
    rig.T_body_cam.q = (rig.T_body_cam.q * so3::exp(d.tail<3>())).normalized();
  }
  if (equations_.time_shift_row() >= 0) rig.time_shift_s += step_[equations_.time_shift_row()];
}

void FixedSolver::take_back(const WindowProblem& p) const noexcept {
  for (std::size_t i = 0; i < p.window.size(); ++i) p.window.state(i).x = kept_.states[i];
  for (std::size_t k = 0; k < num_points_; ++k)
    p.window.landmarks[point_index_[k]].bearing_depth = kept_.points[k];
  for (std::size_t k = 0; k < num_lines_; ++k)
    p.window.lines[line_index_[k]].set_line(kept_.lines[k]);
  p.window.rig_state.T_body_cam = kept_.T_body_cam;
  p.window.rig_state.time_shift_s = kept_.time_shift_s;
}

SolveSummary FixedSolver::solve(const WindowProblem& p, const SolveOptions& options) noexcept {
  SolveSummary out;
  if (!pick(p)) return out;
  hold_weights_ = options.hold_weights;
  double cost = linearise(p);
  out.initial_cost = out.final_cost = cost;
  if (!std::isfinite(cost)) return out;
  double damping = kFirstDamping, growth = 2.0;
  int refusals = 0;
  while (out.iterations < options.max_iterations && refusals < kMostRefusals) {
    ++out.iterations;
    const double promise = find_step(damping);
    bool better = false;
    if (promise > 0.0 && step_.allFinite()) {
      keep(p);
      take_step(p);
      const double next = linearise(p);
      better = next < cost;
      if (better) {
        const bool fine = cost - next < kFineEnd * cost;
        damping = relaxed(damping, (cost - next) / promise);
        cost = next;
        growth = 2.0;
        refusals = 0;
        if (fine) break;
      } else {
        take_back(p);
        if (promise < kFineEnd * cost) {  // at the bottom, as far as numbers tell
          (void)linearise(p);
          break;
        }
        cost = linearise(p);
      }
    }
    if (better) continue;
    ++refusals;
    damping = std::min(damping * growth, kMostDamping);
    growth *= 2.0;
  }
  out.final_cost = cost;
  out.ok = true;
  return out;
}

}  // namespace pled
