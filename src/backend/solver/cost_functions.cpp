#include "src/backend/solver/cost_functions.hpp"

#include <cmath>

#include "pled_vins/geometry/so3.hpp"

namespace pled::ceres_view {
namespace {

/// Writes a Jacobian by a pose's tangent into Ceres' seven columns.
template <int kRows, typename Derived>
void put_pose(double* out, const Eigen::MatrixBase<Derived>& J) {
  Eigen::Map<PoseJacobian<kRows>> map(out);
  map.template leftCols<6>() = J;
  map.col(6).setZero();
}

template <int kRows, typename Derived>
void put_motion(double* out, const Eigen::MatrixBase<Derived>& J) {
  Eigen::Map<MotionJacobian<kRows>> map(out);
  map = J;
}

void put_point(double* out, const Eigen::Matrix<double, 2, 3>& J) {
  Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> map(out);
  map = J;
}

const NavState& jacobian_point(const WindowState& state, const NavState& now,
                               const FactorSettings& settings) {
  return settings.first_estimates && state.has_first ? state.first : now;
}

Pose point_pose(const WindowState& state, const Pose& now, const FactorSettings& settings) {
  return settings.first_estimates && state.has_first ? state.first.T_world_body() : now;
}

}  // namespace

bool PoseManifold::Plus(const double* x, const double* delta, double* out) const {
  const Pose pose = read_pose(x);
  const Eigen::Map<const Vector6d> d(delta);
  write_pose({(pose.q * so3::exp(d.tail<3>())).normalized(), pose.p + d.head<3>()}, out);
  return true;
}

bool PoseManifold::PlusJacobian(const double*, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian);
  J.setIdentity();
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* out) const {
  Eigen::Map<Vector6d>{out} = extrinsic_change(read_pose(x), read_pose(y));
  return true;
}

bool PoseManifold::MinusJacobian(const double*, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> J(jacobian);
  J.setIdentity();
  return true;
}

void write_pose(const Pose& pose, double* out) {
  Eigen::Map<Eigen::Vector3d>{out} = pose.p;
  Eigen::Map<Eigen::Vector4d>{out + 3} = pose.q.coeffs();
}

Pose read_pose(const double* in) {
  return {Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(in + 3)),
          Eigen::Map<const Eigen::Vector3d>(in)};
}

void write_motion(const NavState& state, double* out) {
  Eigen::Map<Eigen::Vector3d>{out} = state.v_wb;
  Eigen::Map<Eigen::Vector3d>{out + 3} = state.bg;
  Eigen::Map<Eigen::Vector3d>{out + 6} = state.ba;
}

NavState read_state(const double* pose, const double* motion) {
  const Pose T = read_pose(pose);
  NavState s;
  s.p_wb = T.p;
  s.q_wb = T.q;
  s.v_wb = Eigen::Map<const Eigen::Vector3d>(motion);
  s.bg = Eigen::Map<const Eigen::Vector3d>(motion + 3);
  s.ba = Eigen::Map<const Eigen::Vector3d>(motion + 6);
  return s;
}

void PointCost::set(const WindowProblem& problem, const Landmark& landmark,
                    const Observation& seen) {
  problem_ = &problem;
  anchor_ = &landmark.observations[0];
  seen_ = &seen;
  set_num_residuals(2);
  auto& sizes = *mutable_parameter_block_sizes();
  sizes.assign({kPoseSize, kPoseSize, kPointSize});
  if (problem.settings.estimate_extrinsic) sizes.push_back(kPoseSize);
  if (problem.settings.estimate_time_shift) sizes.push_back(1);
}

bool PointCost::Evaluate(double const* const* parameters, double* residuals,
                         double** jacobians) const {
  const FactorSettings& settings = problem_->settings;
  const SlidingWindow& window = problem_->window;
  const std::uint8_t refined = problem_->rig.frame_camera;
  const std::size_t shift_block = settings.estimate_extrinsic ? 4 : 3;
  PointFrames frames{read_pose(parameters[0]), window.T_body_cam(anchor_->camera, problem_->rig),
                     read_pose(parameters[1]), window.T_body_cam(seen_->camera, problem_->rig)};
  if (settings.estimate_extrinsic) {
    if (anchor_->camera == refined) frames.T_body_cam_i = read_pose(parameters[3]);
    if (seen_->camera == refined) frames.T_body_cam_j = read_pose(parameters[3]);
  }
  const std::array<double, 3> point{parameters[2][0], parameters[2][1], parameters[2][2]};
  const double shift_s =
      settings.estimate_time_shift ? parameters[shift_block][0] : window.rig_state.time_shift_s;
  const double s = settings.weight_of(seen_->kind, seen_->camera);
  Eigen::Vector2d r;
  PointJacobians J;
  J.with_extrinsic = settings.estimate_extrinsic;
  point_residual(frames, point, *seen_, shift_s, s, r, jacobians ? &J : nullptr);
  Eigen::Map<Eigen::Vector2d>{residuals} = r;
  if (!jacobians) return true;
  const WindowState& i = window.state(anchor_->state);
  const WindowState& j = window.state(seen_->state);
  if (settings.first_estimates && (i.has_first || j.has_first)) {
    frames.T_world_body_i = point_pose(i, frames.T_world_body_i, settings);
    frames.T_world_body_j = point_pose(j, frames.T_world_body_j, settings);
    Eigen::Vector2d ignored;
    point_residual(frames, point, *seen_, shift_s, s, ignored, &J);
  }
  if (jacobians[0]) put_pose<2>(jacobians[0], J.pose_i);
  if (jacobians[1]) put_pose<2>(jacobians[1], J.pose_j);
  if (jacobians[2]) put_point(jacobians[2], J.point);
  if (settings.estimate_extrinsic && jacobians[3]) {
    Eigen::Matrix<double, 2, 6> E = Eigen::Matrix<double, 2, 6>::Zero();
    if (anchor_->camera == refined) E += J.extrinsic_i;
    if (seen_->camera == refined) E += J.extrinsic_j;
    put_pose<2>(jacobians[3], E);
  }
  if (settings.estimate_time_shift && jacobians[shift_block])
    Eigen::Map<Eigen::Vector2d>{jacobians[shift_block]} = J.time_shift;
  return true;
}

void AnchorCost::set(const WindowProblem& problem, const Observation& seen) {
  problem_ = &problem;
  seen_ = &seen;
  set_num_residuals(2);
  auto& sizes = *mutable_parameter_block_sizes();
  sizes.assign({kPointSize});
  if (problem.settings.estimate_time_shift) sizes.push_back(1);
}

bool AnchorCost::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  const FactorSettings& settings = problem_->settings;
  const std::array<double, 3> point{parameters[0][0], parameters[0][1], parameters[0][2]};
  const double shift_s =
      settings.estimate_time_shift ? parameters[1][0] : problem_->window.rig_state.time_shift_s;
  Eigen::Vector2d r;
  PointJacobians J;
  anchor_residual(point, *seen_, shift_s, settings.weight_of(seen_->kind, seen_->camera), r,
                  jacobians ? &J : nullptr);
  Eigen::Map<Eigen::Vector2d>{residuals} = r;
  if (!jacobians) return true;
  if (jacobians[0]) put_point(jacobians[0], J.point);
  if (settings.estimate_time_shift && jacobians[1])
    Eigen::Map<Eigen::Vector2d>{jacobians[1]} = J.time_shift;
  return true;
}

bool DepthCost::Evaluate(double const* const* parameters, double* residuals,
                         double** jacobians) const {
  residuals[0] = weight_ * (parameters[0][2] - mean_pm_);
  residuals[1] = 0;
  if (jacobians && jacobians[0]) {
    Eigen::Matrix<double, 2, 3> J = Eigen::Matrix<double, 2, 3>::Zero();
    J(0, 2) = weight_;
    put_point(jacobians[0], J);
  }
  return true;
}

bool ScalarCost::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  residuals[0] = weight_ * (parameters[0][0] - mean_);
  if (jacobians && jacobians[0]) jacobians[0][0] = weight_;
  return true;
}

bool ImuCost::Evaluate(double const* const* parameters, double* residuals,
                       double** jacobians) const {
  const NavState i = read_state(parameters[0], parameters[1]);
  const NavState j = read_state(parameters[2], parameters[3]);
  const WindowState& from = problem_->window.state(state_ - 1);
  const WindowState& to = problem_->window.state(state_);
  Vector15d r;
  Matrix15d J_i, J_j;
  evaluate_imu(to.preintegration, i, j, jacobian_point(from, i, problem_->settings),
               jacobian_point(to, j, problem_->settings), r, jacobians ? &J_i : nullptr,
               jacobians ? &J_j : nullptr);
  Eigen::Map<Vector15d>{residuals} = r;
  if (!jacobians) return true;
  if (jacobians[0]) put_pose<15>(jacobians[0], J_i.leftCols<6>());
  if (jacobians[1]) put_motion<15>(jacobians[1], J_i.rightCols<9>());
  if (jacobians[2]) put_pose<15>(jacobians[2], J_j.leftCols<6>());
  if (jacobians[3]) put_motion<15>(jacobians[3], J_j.rightCols<9>());
  return true;
}

bool StatePriorCost::Evaluate(double const* const* parameters, double* residuals,
                              double** jacobians) const {
  const NavState x = read_state(parameters[0], parameters[1]);
  const WindowState& state = problem_->window.state(state_);
  Vector15d r;
  Matrix15d J;
  evaluate_state_prior(*state.prior, x, jacobian_point(state, x, problem_->settings), r,
                       jacobians ? &J : nullptr);
  Eigen::Map<Vector15d>{residuals} = r;
  if (!jacobians) return true;
  if (jacobians[0]) put_pose<15>(jacobians[0], J.leftCols<6>());
  if (jacobians[1]) put_motion<15>(jacobians[1], J.rightCols<9>());
  return true;
}

bool StillCost::Evaluate(double const* const* parameters, double* residuals,
                         double** jacobians) const {
  const double weight = std::sqrt(problem_->window.state(state_).still_share) /
                        problem_->settings.still_speed_sigma_mps;
  Eigen::Map<Eigen::Vector3d>{residuals} =
      weight * Eigen::Map<const Eigen::Vector3d>(parameters[0]);
  if (jacobians && jacobians[0]) {
    Eigen::Map<MotionJacobian<3>> J(jacobians[0]);
    J.setZero();
    J.diagonal().setConstant(weight);
  }
  return true;
}

bool SamePlaceCost::Evaluate(double const* const* parameters, double* residuals,
                             double** jacobians) const {
  NavState i, j;
  const Pose T_i = read_pose(parameters[0]), T_j = read_pose(parameters[1]);
  i.p_wb = T_i.p;
  i.q_wb = T_i.q;
  j.p_wb = T_j.p;
  j.q_wb = T_j.q;
  Vector6d r;
  Matrix6d J_i, J_j;
  const FactorSettings& settings = problem_->settings;
  evaluate_same_place(settings, problem_->window.state(to_).still_share, i, j,
                      jacobian_point(problem_->window.state(from_), i, settings),
                      jacobian_point(problem_->window.state(to_), j, settings), r,
                      jacobians ? &J_i : nullptr, jacobians ? &J_j : nullptr);
  Eigen::Map<Vector6d>{residuals} = r;
  if (!jacobians) return true;
  if (jacobians[0]) put_pose<6>(jacobians[0], J_i);
  if (jacobians[1]) put_pose<6>(jacobians[1], J_j);
  return true;
}

bool ExtrinsicCost::Evaluate(double const* const* parameters, double* residuals,
                             double** jacobians) const {
  const FactorSettings& settings = problem_->settings;
  const Vector6d d =
      extrinsic_change(problem_->window.rig_state.mean_T_body_cam, read_pose(parameters[0]));
  Vector6d weight;
  weight.head<3>().setConstant(1.0 / settings.extrinsic_sigma_m);
  weight.tail<3>().setConstant(1.0 / settings.extrinsic_sigma_rad);
  Eigen::Map<Vector6d>{residuals} = weight.cwiseProduct(d);
  if (!jacobians || !jacobians[0]) return true;
  Matrix6d J = Matrix6d::Identity();
  J.bottomRightCorner<3, 3>() = so3::right_jacobian_inverse(d.tail<3>());
  const Matrix6d whitened = weight.asDiagonal() * J;
  put_pose<6>(jacobians[0], whitened);
  return true;
}

void MarginalCost::set(const WindowProblem& problem) {
  problem_ = &problem;
  blocks_.clear();
  const MarginalPrior& prior = problem.window.prior;
  auto& sizes = *mutable_parameter_block_sizes();
  sizes.clear();
  const auto note = [&](int column, int state, int tangent, int ambient) {
    if (column < 0) return;
    (void)blocks_.push_back({column, state, tangent});
    sizes.push_back(ambient);
  };
  for (std::size_t i = 0; i < problem.window.size(); ++i) {
    note(prior.pose_column[i], static_cast<int>(i), kPoseDim, kPoseSize);
    note(prior.motion_column[i], static_cast<int>(i), kMotionDim, kMotionDim);
  }
  note(prior.extrinsic_column, -1, kExtrinsicDim, kPoseSize);
  note(prior.time_shift_column, -1, 1, 1);
  set_num_residuals(static_cast<int>(prior.J.rows()));
}

bool MarginalCost::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  const MarginalPrior& prior = problem_->window.prior;
  const RigState& rig = problem_->window.rig_state;
  PriorVector dx = PriorVector::Zero(prior.J.cols());
  for (std::size_t k = 0; k < blocks_.size(); ++k) {
    const Block& block = blocks_[k];
    const double* x = parameters[k];
    if (block.size == kMotionDim) {
      double first[kMotionDim];
      write_motion(problem_->window.state(static_cast<std::size_t>(block.state)).first, first);
      for (int i = 0; i < kMotionDim; ++i) dx[block.column + i] = x[i] - first[i];
    } else if (block.size == kPoseDim) {
      const Pose first =
          block.state < 0
              ? rig.first_T_body_cam
              : problem_->window.state(static_cast<std::size_t>(block.state)).first.T_world_body();
      dx.segment<6>(block.column) = extrinsic_change(first, read_pose(x));
    } else {
      dx[block.column] = x[0] - rig.first_time_shift_s;
    }
  }
  Eigen::Map<Eigen::VectorXd> r(residuals, prior.r0.size());
  r = prior.r0;
  r.noalias() += prior.J * dx;
  if (!jacobians) return true;
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  for (std::size_t k = 0; k < blocks_.size(); ++k) {
    if (!jacobians[k]) continue;
    const Block& block = blocks_[k];
    const int ambient = block.size == kPoseDim ? kPoseSize : block.size;
    Eigen::Map<Rows> J(jacobians[k], prior.J.rows(), ambient);
    J.setZero();
    J.leftCols(block.size) = prior.J.middleCols(block.column, block.size);
  }
  return true;
}

}  // namespace pled::ceres_view
