#include "pled_vins/backend/factors.hpp"

#include <cmath>

#include "pled_vins/geometry/so3.hpp"

namespace pled {

double robust_gain(double robust_scale) noexcept {
  // Substituting u = s/2, whose density is e^-u; midpoint sums, exact to 1e-6.
  const double c2 = robust_scale * robust_scale;
  constexpr int kSteps = 8000;
  constexpr double kStep = 40.0 / kSteps;
  double w1 = 0, w2 = 0, w2u = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double u = (k + 0.5) * kStep;
    const double density = std::exp(-u) * kStep;
    const double w = 1.0 / (1.0 + 2.0 * u / c2);
    w1 += density * w;
    w2 += density * w * w;
    w2u += density * w * w * u;
  }
  return w2 * w2 / (w2u * w1);
}

void set_feature_noise(FactorSettings& settings, const RigCalibration& rig,
                       const FeatureSigmas& sigmas_px) noexcept {
  for (std::size_t kind = 0; kind < kFeatureKinds; ++kind)
    for (std::size_t c = 0; c < limits::kMaxCameras; ++c)
      settings.sigmas_per_unit[kind][c] = as_published(settings.robust.mode)
                                              ? kPaperSigmasPerUnit
                                              : mean_focal_px(rig.cameras[c]) / sigmas_px[kind];
}

FactorSettings make_factor_settings(const BackendConfig& config,
                                    const RigCalibration& rig) noexcept {
  FactorSettings s;
  s.robust = config.robust;
  s.fusion = config.fusion;
  set_feature_noise(s, rig,
                    {config.point_sigma_px, config.event_point_sigma_px, config.line_sigma_px});
  s.robust_scale = config.robust_scale;
  s.sight_gain = as_published(config.robust.mode) ? 1.0 : robust_gain(config.robust_scale);
  s.extrinsic_sigma_m = config.extrinsic_sigma_m;
  s.extrinsic_sigma_rad = config.extrinsic_sigma_rad;
  s.time_shift_sigma_s = config.time_shift_sigma_s;
  s.estimate_extrinsic = config.estimate_extrinsic;
  s.estimate_time_shift = config.estimate_time_shift;
  return s;
}

PointFrames point_frames(const SlidingWindow& window, const RigCalibration& rig,
                         const Observation& anchor, const Observation& seen,
                         bool first_estimates) noexcept {
  return {window.state(anchor.state).linearisation(first_estimates).T_world_body(),
          window.T_body_cam(anchor.camera, rig),
          window.state(seen.state).linearisation(first_estimates).T_world_body(),
          window.T_body_cam(seen.camera, rig)};
}

bool evaluate_point(const SlidingWindow& window, const RigCalibration& rig,
                    const FactorSettings& settings, const Landmark& landmark,
                    const Observation& seen, Eigen::Vector2d& residual,
                    PointJacobians* jacobians) noexcept {
  const Observation& anchor = landmark.observations[0];
  const double s = settings.weight_of(seen.kind, seen.camera);
  const std::array<double, 3>& point = landmark.bearing_depth;
  const double shift_s = window.rig_state.time_shift_s;
  if (&seen == &anchor) {
    anchor_residual(point, seen, shift_s, s, residual, jacobians);
    return true;
  }
  const bool moved = settings.first_estimates &&
                     (window.state(anchor.state).has_first || window.state(seen.state).has_first);
  const PointFrames now = point_frames(window, rig, anchor, seen, false);
  if (!moved || !jacobians)
    return point_residual(now, point, seen, shift_s, s, residual, jacobians);
  Eigen::Vector2d ignored;
  point_residual(point_frames(window, rig, anchor, seen, true), point, seen, shift_s, s, ignored,
                 jacobians);
  return point_residual(now, point, seen, shift_s, s, residual, nullptr);
}

bool evaluate_line(const SlidingWindow& window, const RigCalibration& rig,
                   const FactorSettings& settings, const LineLandmark& landmark,
                   const LineObservation& seen, Eigen::Vector2d& residual,
                   LineJacobians* jacobians) noexcept {
  const WindowState& state = window.state(seen.state);
  const double s = settings.weight_of(FeatureKind::kLine, seen.camera);
  const double shift_s = window.rig_state.time_shift_s;
  const OrthonormalLine line = landmark.line();
  LineFrames frames{state.x.T_world_body(), window.T_body_cam(seen.camera, rig),
                    landmark.origin_world()};
  const bool moved = settings.first_estimates && state.has_first;
  if (!moved || !jacobians)
    return line_residual(frames, line, seen, shift_s, s, residual, jacobians);
  const bool has_picture = line_residual(frames, line, seen, shift_s, s, residual, nullptr);
  frames.T_world_body = state.first.T_world_body();
  Eigen::Vector2d ignored;
  line_residual(frames, line, seen, shift_s, s, ignored, jacobians);
  return has_picture;
}

void evaluate_imu(const Preintegration& preintegration, const NavState& i, const NavState& j,
                  const NavState& linearised_i, const NavState& linearised_j, Vector15d& residual,
                  Matrix15d* d_r_d_i, Matrix15d* d_r_d_j) noexcept {
  const Matrix15d& S = preintegration.sqrt_information();
  if (d_r_d_i && d_r_d_j) {
    Matrix15d J_i, J_j;
    preintegration.residual(linearised_i, linearised_j, residual, &J_i, &J_j);
    d_r_d_i->noalias() = S * J_i;
    d_r_d_j->noalias() = S * J_j;
  }
  Vector15d r;
  preintegration.residual(i, j, r, nullptr, nullptr);
  residual.noalias() = S * r;
}

void evaluate_state_prior(const StatePrior& prior, const NavState& x, const NavState& linearised,
                          Vector15d& residual, Matrix15d* d_r_d_x) noexcept {
  residual = prior.sqrt_information * box_minus(x, prior.mean);
  if (!d_r_d_x) return;
  *d_r_d_x = prior.sqrt_information;
  const Vector15d d = box_minus(linearised, prior.mean);
  const Eigen::Matrix3d J = so3::right_jacobian_inverse(d.segment<3>(3));
  const Eigen::Matrix<double, 15, 3> turned = prior.sqrt_information.middleCols<3>(3) * J;
  d_r_d_x->middleCols<3>(3) = turned;
}

void evaluate_same_place(const FactorSettings& settings, double share, const NavState& i,
                         const NavState& j, const NavState& linearised_i,
                         const NavState& linearised_j, Vector6d& residual, Matrix6d* d_r_d_i,
                         Matrix6d* d_r_d_j) noexcept {
  const double sp = std::sqrt(share) / settings.still_position_sigma_m;
  const double sq = std::sqrt(share) / settings.still_angle_sigma_rad;
  residual.head<3>() = sp * (i.q_wb.conjugate() * (j.p_wb - i.p_wb));
  residual.tail<3>() = sq * so3::log(i.q_wb.conjugate() * j.q_wb);
  if (!d_r_d_i || !d_r_d_j) return;
  const NavState& a = linearised_i;
  const NavState& b = linearised_j;
  const Eigen::Matrix3d R_aw = a.q_wb.toRotationMatrix().transpose();
  const Eigen::Vector3d p_ab = R_aw * (b.p_wb - a.p_wb);
  const Eigen::Vector3d turn = so3::log(a.q_wb.conjugate() * b.q_wb);
  const Eigen::Matrix3d J = so3::right_jacobian_inverse(turn);
  d_r_d_i->setZero();
  d_r_d_j->setZero();
  d_r_d_i->block<3, 3>(0, 0) = -sp * R_aw;
  d_r_d_i->block<3, 3>(0, 3) = sp * so3::skew(p_ab);
  d_r_d_j->block<3, 3>(0, 0) = sp * R_aw;
  d_r_d_i->block<3, 3>(3, 3) = -sq * J * (b.q_wb.conjugate() * a.q_wb).toRotationMatrix();
  d_r_d_j->block<3, 3>(3, 3) = sq * J;
}

Vector6d extrinsic_change(const Pose& from, const Pose& to) noexcept {
  Vector6d d;
  d.head<3>() = to.p - from.p;
  d.tail<3>() = so3::log(from.q.conjugate() * to.q);
  return d;
}

void evaluate_marginal_prior(const SlidingWindow& window, PriorVector& residual) noexcept {
  const MarginalPrior& prior = window.prior;
  PriorVector dx = PriorVector::Zero(prior.J.cols());
  for (std::size_t i = 0; i < window.size(); ++i) {
    const int pose = prior.pose_column[i];
    const int motion = prior.motion_column[i];
    if (pose < 0 && motion < 0) continue;
    const Vector15d d = box_minus(window.state(i).x, window.state(i).first);
    if (pose >= 0) dx.segment<kPoseDim>(pose) = d.head<kPoseDim>();
    if (motion >= 0) dx.segment<kMotionDim>(motion) = d.tail<kMotionDim>();
  }
  const RigState& rig = window.rig_state;
  if (prior.extrinsic_column >= 0)
    dx.segment<kExtrinsicDim>(prior.extrinsic_column) =
        extrinsic_change(rig.first_T_body_cam, rig.T_body_cam);
  if (prior.time_shift_column >= 0)
    dx[prior.time_shift_column] = rig.time_shift_s - rig.first_time_shift_s;
  residual = prior.r0;
  residual.noalias() += prior.J * dx;
}

}  // namespace pled
