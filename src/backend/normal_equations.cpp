#include "pled_vins/backend/normal_equations.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pled_vins/geometry/so3.hpp"
#include "src/backend/row_of.hpp"

namespace pled {
void NormalEquations::reset(const SlidingWindow& window, const FactorSettings& settings) noexcept {
  dim_ = row_of(window.size());
  extrinsic_row_ = settings.estimate_extrinsic ? dim_ : -1;
  if (settings.estimate_extrinsic) dim_ += kExtrinsicDim;
  time_shift_row_ = settings.estimate_time_shift ? dim_ : -1;
  if (settings.estimate_time_shift) dim_ += 1;
  cost_ = 0.0;
  H_.setZero(dim_, dim_);
  b_.setZero(dim_);
}

void NormalEquations::add_states(const SlidingWindow& window,
                                 const FactorSettings& settings) noexcept {
  reset(window, settings);
  add_marginal_prior(window);
  add_calibration_prior(window, settings);
  for (std::size_t i = 0; i < window.size(); ++i) {
    add_imu(window, i, settings);
    add_state(window, i, settings);
    add_same_place(window, i, settings);
  }
}

void NormalEquations::add_all(const SlidingWindow& window, const RigCalibration& rig,
                              const FactorSettings& settings) noexcept {
  add_states(window, settings);
  for (const Landmark& landmark : window.landmarks)
    if (landmark.in_solver)
      add_point(window, rig, settings, landmark, landmark.observations.size());
  for (const LineLandmark& line : window.lines)
    if (line.in_solver) add_line(window, rig, settings, line, line.observations.size());
  complete();
}

void NormalEquations::add_imu(const SlidingWindow& window, std::size_t i,
                              const FactorSettings& settings) noexcept {
  if (i == 0 || !window.state(i).has_imu) return;
  const WindowState& from = window.state(i - 1);
  const WindowState& to = window.state(i);
  Vector15d r;
  Matrix15d J_i, J_j;
  evaluate_imu(to.preintegration, from.x, to.x, from.linearisation(settings.first_estimates),
               to.linearisation(settings.first_estimates), r, &J_i, &J_j);
  const int a = row_of(i - 1), b = row_of(i);
  H_.block<15, 15>(a, a).noalias() += J_i.transpose() * J_i;
  H_.block<15, 15>(b, b).noalias() += J_j.transpose() * J_j;
  const Matrix15d cross = J_i.transpose() * J_j;
  H_.block<15, 15>(a, b) += cross;
  H_.block<15, 15>(b, a) += cross.transpose();
  b_.segment<15>(a).noalias() += J_i.transpose() * r;
  b_.segment<15>(b).noalias() += J_j.transpose() * r;
  cost_ += 0.5 * r.squaredNorm();
}

void NormalEquations::add_state(const SlidingWindow& window, std::size_t i,
                                const FactorSettings& settings) noexcept {
  const WindowState& s = window.state(i);
  const int a = row_of(i);
  if (s.prior) {
    Vector15d r;
    Matrix15d J;
    evaluate_state_prior(*s.prior, s.x, s.linearisation(settings.first_estimates), r, &J);
    H_.block<15, 15>(a, a).noalias() += J.transpose() * J;
    b_.segment<15>(a).noalias() += J.transpose() * r;
    cost_ += 0.5 * r.squaredNorm();
  }
  if (s.still) {
    const double sigma_mps = settings.still_speed_sigma_mps;
    const double w = s.still_share / (sigma_mps * sigma_mps);
    H_.diagonal().segment<3>(a + 6).array() += w;
    b_.segment<3>(a + 6) += w * s.x.v_wb;
    cost_ += 0.5 * w * s.x.v_wb.squaredNorm();
  }
}

void NormalEquations::add_same_place(const SlidingWindow& window, std::size_t i,
                                     const FactorSettings& settings) noexcept {
  const WindowState& to = window.state(i);
  if (to.still_as < 0) return;
  const auto as = static_cast<std::size_t>(to.still_as);
  const WindowState& from = window.state(as);
  Vector6d r;
  Matrix6d J_i, J_j;
  evaluate_same_place(settings, to.still_share, from.x, to.x,
                      from.linearisation(settings.first_estimates),
                      to.linearisation(settings.first_estimates), r, &J_i, &J_j);
  const int a = row_of(as), b = row_of(i);
  H_.block<6, 6>(a, a).noalias() += J_i.transpose() * J_i;
  H_.block<6, 6>(b, b).noalias() += J_j.transpose() * J_j;
  const Matrix6d cross = J_i.transpose() * J_j;
  H_.block<6, 6>(a, b) += cross;
  H_.block<6, 6>(b, a) += cross.transpose();
  b_.segment<6>(a).noalias() += J_i.transpose() * r;
  b_.segment<6>(b).noalias() += J_j.transpose() * r;
  cost_ += 0.5 * r.squaredNorm();
}

void NormalEquations::add_marginal_prior(const SlidingWindow& window) noexcept {
  const MarginalPrior& prior = window.prior;
  if (!prior.valid) return;
  evaluate_marginal_prior(window, prior_residual_);
  cost_ += 0.5 * prior_residual_.squaredNorm();
  const PriorMatrix& J = prior.J;
  prior_H_.noalias() = J.transpose() * J;
  const PriorVector gradient = J.transpose() * prior_residual_;
  struct Block {
    int column, row, size;
  };
  FixedVector<Block, 2 * limits::kWindowStates + 2> blocks;
  const auto note = [&blocks](int column, int row, int size) {
    if (column >= 0 && row >= 0) (void)blocks.push_back({column, row, size});
  };
  for (std::size_t i = 0; i < window.size(); ++i) {
    note(prior.pose_column[i], row_of(i), kPoseDim);
    note(prior.motion_column[i], row_of(i) + kPoseDim, kMotionDim);
  }
  note(prior.extrinsic_column, extrinsic_row_, kExtrinsicDim);
  note(prior.time_shift_column, time_shift_row_, 1);
  for (const Block& a : blocks) {
    b_.segment(a.row, a.size) += gradient.segment(a.column, a.size);
    for (const Block& c : blocks)
      H_.block(a.row, c.row, a.size, c.size) += prior_H_.block(a.column, c.column, a.size, c.size);
  }
}

void NormalEquations::add_calibration_prior(const SlidingWindow& window,
                                            const FactorSettings& settings) noexcept {
  const RigState& rig = window.rig_state;
  if (extrinsic_row_ >= 0) {
    const Vector6d d = extrinsic_change(rig.mean_T_body_cam, rig.T_body_cam);
    const Eigen::Matrix3d J = so3::right_jacobian_inverse(d.tail<3>());
    const double wp = 1.0 / (settings.extrinsic_sigma_m * settings.extrinsic_sigma_m);
    const double wq = 1.0 / (settings.extrinsic_sigma_rad * settings.extrinsic_sigma_rad);
    H_.diagonal().segment<3>(extrinsic_row_).array() += wp;
    b_.segment<3>(extrinsic_row_) += wp * d.head<3>();
    H_.block<3, 3>(extrinsic_row_ + 3, extrinsic_row_ + 3) += wq * J.transpose() * J;
    b_.segment<3>(extrinsic_row_ + 3) += wq * J.transpose() * d.tail<3>();
    cost_ += 0.5 * (wp * d.head<3>().squaredNorm() + wq * d.tail<3>().squaredNorm());
  }
  if (time_shift_row_ >= 0) {
    const double w = 1.0 / (settings.time_shift_sigma_s * settings.time_shift_sigma_s);
    H_(time_shift_row_, time_shift_row_) += w;
    b_[time_shift_row_] += w * rig.time_shift_s;
    cost_ += 0.5 * w * rig.time_shift_s * rig.time_shift_s;
  }
}

}  // namespace pled
