#include "pled_vins/backend/normal_equations.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pled_vins/geometry/so3.hpp"

namespace pled {
namespace {

/// Information below which a depth counts as unknown, 1/(1/m)^2: a point at this
/// information says nothing but its bearing.
constexpr double kMinDepthInformation = 1e-6;

/// A block of rows; row < 0: not there.
struct Span {
  int row, size;
};

int row_of(std::size_t state) { return static_cast<int>(state) * kStateDim; }

}  // namespace

void NormalEquations::reset(const SlidingWindow& window, const FactorSettings& settings) noexcept {
  dim_ = row_of(window.size());
  extrinsic_row_ = settings.estimate_extrinsic ? dim_ : -1;
  if (settings.estimate_extrinsic) dim_ += kExtrinsicDim;
  time_shift_row_ = settings.estimate_time_shift ? dim_ : -1;
  if (settings.estimate_time_shift) dim_ += 1;
  H_.setZero(dim_, dim_);
  b_.setZero(dim_);
}

void NormalEquations::add_all(const SlidingWindow& window, const RigCalibration& rig,
                              const FactorSettings& settings) noexcept {
  reset(window, settings);
  add_marginal_prior(window);
  add_calibration_prior(window, settings);
  for (std::size_t i = 0; i < window.size(); ++i) {
    add_imu(window, i, settings);
    add_state(window, i, settings);
    add_same_place(window, i, settings);
  }
  for (const Landmark& landmark : window.landmarks)
    if (landmark.in_solver)
      add_point(window, rig, settings, landmark, landmark.observations.size());
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
  }
  if (s.still) {
    const double sigma_mps = settings.still_speed_sigma_mps;
    const double w = s.still_share / (sigma_mps * sigma_mps);
    H_.diagonal().segment<3>(a + 6).array() += w;
    b_.segment<3>(a + 6) += w * s.x.v_wb;
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
}

void NormalEquations::add_marginal_prior(const SlidingWindow& window) noexcept {
  const MarginalPrior& prior = window.prior;
  if (!prior.valid) return;
  evaluate_marginal_prior(window, prior_residual_);
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
  }
  if (time_shift_row_ >= 0) {
    const double w = 1.0 / (settings.time_shift_sigma_s * settings.time_shift_sigma_s);
    H_(time_shift_row_, time_shift_row_) += w;
    b_[time_shift_row_] += w * rig.time_shift_s;
  }
}

void NormalEquations::add_point(const SlidingWindow& window, const RigCalibration& rig,
                                const FactorSettings& settings, const Landmark& landmark,
                                std::size_t count) noexcept {
  const auto& seen = landmark.observations;
  const std::size_t end = std::min(count, seen.size());
  if (end < 2) return;
  const int a = row_of(seen[0].state);
  W_.setZero(dim_, 3);
  Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
  h(2, 2) = kMinDepthInformation;
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  FixedVector<Span, limits::kWindowStates + 2> spans;
  (void)spans.push_back({a, kPoseDim});
  for (std::size_t k = 0; k < end; ++k) {
    Eigen::Vector2d r;
    PointJacobians J;
    J.with_extrinsic = extrinsic_row_ >= 0;
    evaluate_point(window, rig, settings, landmark, seen[k], r, &J);
    const double w = settings.point_gain * cauchy_weight(r.squaredNorm(), settings.robust_scale);
    const int b = row_of(seen[k].state);
    // One dense row pair over [pose_i, pose_j, extrinsic, shift]; the anchor's has no poses.
    const std::array<Span, 4> parts{
        {{k == 0 ? -1 : a, 6}, {k == 0 ? -1 : b, 6}, {extrinsic_row_, 6}, {time_shift_row_, 1}}};
    Eigen::Matrix<double, 2, 19> D;
    D << J.pose_i, J.pose_j, Eigen::Matrix<double, 2, 6>::Zero(), J.time_shift;
    if (seen[0].camera == rig.frame_camera) D.middleCols<6>(12) += J.extrinsic_i;
    if (seen[k].camera == rig.frame_camera) D.middleCols<6>(12) += J.extrinsic_j;
    const Eigen::Matrix<double, 19, 2> Dw = w * D.transpose();
    const Eigen::Matrix<double, 19, 19> DD = Dw * D;
    const Eigen::Matrix<double, 19, 1> Dr = Dw * r;
    const Eigen::Matrix<double, 19, 3> Dl = Dw * J.point;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      if (parts[p].row < 0) continue;
      const int from = static_cast<int>(p) * 6;
      b_.segment(parts[p].row, parts[p].size) += Dr.segment(from, parts[p].size);
      W_.middleRows(parts[p].row, parts[p].size) += Dl.middleRows(from, parts[p].size);
      for (std::size_t q = 0; q < parts.size(); ++q)
        if (parts[q].row >= 0)
          H_.block(parts[p].row, parts[q].row, parts[p].size, parts[q].size) +=
              DD.block(from, static_cast<int>(q) * 6, parts[p].size, parts[q].size);
    }
    if (k > 0) (void)spans.push_back({b, kPoseDim});
    h += w * J.point.transpose() * J.point;
    g += w * J.point.transpose() * r;
  }
  if (extrinsic_row_ >= 0) (void)spans.push_back({extrinsic_row_, kExtrinsicDim});
  if (time_shift_row_ >= 0) (void)spans.push_back({time_shift_row_, 1});
  const Eigen::Matrix3d h_inverse = h.inverse();
  for (const Span& p : spans) {
    const Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 6, 3> part =
        W_.middleRows(p.row, p.size) * h_inverse;
    b_.segment(p.row, p.size) -= part * g;
    for (const Span& q : spans)
      H_.block(p.row, q.row, p.size, q.size) -= part * W_.middleRows(q.row, q.size).transpose();
  }
}

}  // namespace pled
