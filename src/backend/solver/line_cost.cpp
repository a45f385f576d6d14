// Lines, and the losses of sightings, as Ceres sees them.

#include "pled_vins/backend/feature_loss.hpp"
#include "pled_vins/geometry/line.hpp"
#include "src/backend/solver/cost_functions.hpp"

namespace pled::ceres_view {

void write_line(const OrthonormalLine& line, double* out) {
  Eigen::Map<Eigen::Vector4d>{out} = line.U.coeffs();
  out[4] = line.phi_rad;
}

OrthonormalLine read_line(const double* in) {
  return {Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(in)), in[4]};
}

bool LineManifold::Plus(const double* x, const double* delta, double* out) const {
  OrthonormalLine moved = box_plus(read_line(x), Eigen::Map<const LineTangent>(delta));
  moved.U.normalize();
  write_line(moved, out);
  return true;
}

bool LineManifold::PlusJacobian(const double*, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, kLineSize, 4, Eigen::RowMajor>> J(jacobian);
  J.setIdentity();
  return true;
}

bool LineManifold::Minus(const double* y, const double* x, double* out) const {
  Eigen::Map<LineTangent>{out} = box_minus(read_line(y), read_line(x));
  return true;
}

bool LineManifold::MinusJacobian(const double*, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 4, kLineSize, Eigen::RowMajor>> J(jacobian);
  J.setIdentity();
  return true;
}

/// The second derivative is never positive; Ceres then leaves it out, as 0 does.
void SightLoss::Evaluate(double squared, double out[3]) const {
  out[0] = sight_loss(*settings_, squared, w_);
  out[1] = sight_weight(*settings_, squared, w_);
  out[2] = 0.0;
}

void LineCost::set(const WindowProblem& problem, const LineLandmark& line,
                   const LineObservation& seen) {
  problem_ = &problem;
  line_ = &line;
  seen_ = &seen;
  set_num_residuals(2);
  auto& sizes = *mutable_parameter_block_sizes();
  sizes.assign({kPoseSize, kLineSize});
  if (problem.settings.estimate_extrinsic) sizes.push_back(kPoseSize);
  if (problem.settings.estimate_time_shift) sizes.push_back(1);
}

bool LineCost::Evaluate(double const* const* parameters, double* residuals,
                        double** jacobians) const {
  const FactorSettings& settings = problem_->settings;
  const SlidingWindow& window = problem_->window;
  const bool refined = seen_->camera == problem_->rig.frame_camera;
  const std::size_t shift_block = settings.estimate_extrinsic ? 3 : 2;
  LineFrames frames{read_pose(parameters[0]), window.T_body_cam(seen_->camera, problem_->rig),
                    line_->origin_world()};
  if (settings.estimate_extrinsic && refined) frames.T_body_cam = read_pose(parameters[2]);
  const OrthonormalLine line = read_line(parameters[1]);
  const double shift_s =
      settings.estimate_time_shift ? parameters[shift_block][0] : window.rig_state.time_shift_s;
  const double s = settings.weight_of(FeatureKind::kLine, seen_->camera);
  Eigen::Vector2d r;
  line_residual(frames, line, *seen_, shift_s, s, r, nullptr);
  Eigen::Map<Eigen::Vector2d>{residuals} = r;
  if (!jacobians) return true;
  const WindowState& state = window.state(seen_->state);
  if (settings.first_estimates && state.has_first) frames.T_world_body = state.first.T_world_body();
  LineJacobians J;
  J.with_extrinsic = settings.estimate_extrinsic;
  line_residual(frames, line, *seen_, shift_s, s, r, &J);
  if (jacobians[0]) {
    Eigen::Map<PoseJacobian<2>> out(jacobians[0]);
    out << J.pose, Eigen::Vector2d::Zero();
  }
  if (jacobians[1]) {
    Eigen::Map<Eigen::Matrix<double, 2, kLineSize, Eigen::RowMajor>> out(jacobians[1]);
    out << J.line, Eigen::Vector2d::Zero();
  }
  if (settings.estimate_extrinsic && jacobians[2]) {
    Eigen::Map<PoseJacobian<2>> out(jacobians[2]);
    out.setZero();
    if (refined) out.leftCols<6>() = J.extrinsic;
  }
  if (settings.estimate_time_shift && jacobians[shift_block])
    Eigen::Map<Eigen::Vector2d>{jacobians[shift_block]} = J.time_shift;
  return true;
}

}  // namespace pled::ceres_view
