#include "pled_vins/imu/truth_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "pled_vins/imu/imu_history.hpp"

namespace pled {
namespace {

constexpr Duration kEndTolerance{1'000};
constexpr double kStanding_mps = 0.03;
constexpr Duration kBeforeLeaving = Duration::from_ms(500);
constexpr double kStandingExtra_s = 1.0;

/// The states at the start while the body stands, without the last half second.
std::span<const NavState> standing_part(std::span<const NavState> truth) noexcept {
  std::size_t n = 0;
  while (n < truth.size() && truth[n].v_wb.norm() < kStanding_mps) ++n;
  if (n < truth.size()) {
    const Timestamp leaving = truth[n].t;
    while (n > 0 && truth[n - 1].t > leaving - kBeforeLeaving) --n;
  }
  return truth.first(n);
}

/// Covariance of the residual that comes from the two true states.
Matrix15d truth_covariance(const Preintegration& p, const NavState& i, const NavState& j,
                           const TruthUncertainty& u, Vector15d& r) noexcept {
  Matrix15d d_i;
  Matrix15d d_j;
  p.residual(i, j, r, &d_i, &d_j);
  Vector15d sigma;
  sigma << Eigen::Vector3d::Constant(u.position_m), Eigen::Vector3d::Constant(u.attitude_rad),
      Eigen::Vector3d::Constant(u.velocity_mps), Eigen::Vector3d::Constant(u.gyro_bias_radps),
      Eigen::Vector3d::Constant(u.accel_bias_mps2);
  const Vector15d variance = sigma.cwiseAbs2();
  // The biases of the end take no part in p, theta and v. A tilt e of the frame turns gravity by
  // g x e: an acceleration that nobody felt.
  const double tilt_mps2 = kGravityWorld.norm() * u.frame_tilt_rad;
  const double dt_s = p.dt_s();
  const Eigen::Matrix3d R_it = i.q_wb.conjugate().toRotationMatrix();
  const Eigen::Matrix3d horizontal =
      R_it * Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal() * R_it.transpose();
  Matrix15d P =
      d_i * variance.asDiagonal() * d_i.transpose() + d_j * variance.asDiagonal() * d_j.transpose();
  Eigen::Matrix<double, 15, 3> d_tilt = Eigen::Matrix<double, 15, 3>::Zero();
  d_tilt.block<3, 3>(0, 0) = 0.5 * dt_s * dt_s * tilt_mps2 * Eigen::Matrix3d::Identity();
  d_tilt.block<3, 3>(6, 0) = dt_s * tilt_mps2 * Eigen::Matrix3d::Identity();
  P += d_tilt * horizontal * d_tilt.transpose();
  return P;
}

/// Index of the first state after `i` at or after (within tolerance) `wanted`; size if none.
std::size_t find_end(std::span<const NavState> truth, std::size_t i, Timestamp wanted) noexcept {
  std::size_t j = i + 1;
  while (j < truth.size() && truth[j].t < wanted - kEndTolerance) ++j;
  return j;
}

/// e^T P^-1 e / n of `size` rows from `row`.
template <int kSize>
double nees_per_dof(const Vector9d& e, const Matrix9d& P, Eigen::Index row) noexcept {
  using Block = Eigen::Matrix<double, kSize, kSize>;
  const Eigen::Matrix<double, kSize, 1> part = e.segment<kSize>(row);
  const Block block = P.block<kSize, kSize>(row, row);
  const Eigen::LLT<Block> llt(block);
  return part.dot(llt.solve(part)) / kSize;
}

void accumulate(const Vector9d& e, const Matrix9d& P, PreintegrationCheck& sum) noexcept {
  ++sum.compared;
  sum.mean_nees_per_dof += nees_per_dof<9>(e, P, 0);
  sum.position_nees_per_dof += nees_per_dof<3>(e, P, 0);
  sum.attitude_nees_per_dof += nees_per_dof<3>(e, P, 3);
  sum.velocity_nees_per_dof += nees_per_dof<3>(e, P, 6);
  sum.position_rms_m += e.segment<3>(0).squaredNorm();
  sum.attitude_rms_rad += e.segment<3>(3).squaredNorm();
  sum.velocity_rms_mps += e.segment<3>(6).squaredNorm();
}

/// Sums to means and roots; 0 / 0 is NaN, as promised.
void finish(PreintegrationCheck& c) noexcept {
  const auto n = static_cast<double>(c.compared);
  for (double* nees : {&c.mean_nees_per_dof, &c.position_nees_per_dof, &c.attitude_nees_per_dof,
                       &c.velocity_nees_per_dof}) {
    *nees /= n;
  }
  for (double* rms : {&c.position_rms_m, &c.attitude_rms_rad, &c.velocity_rms_mps}) {
    *rms = std::sqrt(*rms / n);
  }
}

}  // namespace

std::optional<TruthUncertainty> measure_standing_truth(std::span<const NavState> truth,
                                                       std::span<const ImuSample> imu,
                                                       double interval_s) noexcept {
  const std::span<const NavState> standing = standing_part(truth);
  const std::size_t n = standing.size();
  if (n < 2 ||
      !((standing.back().t - standing.front().t).seconds() >= interval_s + kStandingExtra_s)) {
    return std::nullopt;
  }
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();  // of change in position, attitude, velocity
  double pairs = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = find_end(standing, i, standing[i].t + Duration::from_s(interval_s));
    if (j >= n) break;
    const Vector15d d = box_minus(standing[j], standing[i]);
    squares += Eigen::Vector3d(d.segment<3>(0).squaredNorm(), d.segment<3>(3).squaredNorm(),
                               d.segment<3>(6).squaredNorm());
    pairs += 1.0;
  }
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  double samples = 0.0;
  for (const ImuSample& s : imu) {
    if (s.t < standing.front().t || s.t > standing.back().t) continue;
    rate += Eigen::Map<const Eigen::Vector3d>(s.gyro_radps.data()) - standing.front().bg;
    force += standing.front().q_wb *
             (Eigen::Map<const Eigen::Vector3d>(s.accel_mps2.data()) - standing.front().ba);
    samples += 1.0;
  }
  if (!(samples > 0.0)) return std::nullopt;
  // A change is the difference of two states, each with three axes.
  const Eigen::Vector3d sigma = (squares / (6.0 * pairs)).cwiseSqrt();
  TruthUncertainty u;
  u.position_m = sigma.x();
  u.attitude_rad = sigma.y();
  u.velocity_mps = sigma.z();
  u.gyro_bias_radps = rate.norm() / samples / std::sqrt(3.0);
  // One attitude cannot tell a leaning frame from a biased accelerometer: it is counted as each.
  u.accel_bias_mps2 = (force / samples + kGravityWorld).norm() / std::sqrt(3.0);
  u.frame_tilt_rad = force.head<2>().norm() / force.norm() / std::sqrt(2.0);
  return u;
}

PreintegrationCheck check_preintegration(std::span<const NavState> truth,
                                         std::span<const ImuSample> imu, double interval_s,
                                         const ImuNoise& noise,
                                         const TruthUncertainty& uncertainty) noexcept {
  PreintegrationCheck result;
  ImuHistory history;
  std::array<ImuSample, limits::kMaxImuPerInterval> piece;
  std::size_t fed = 0;
  std::size_t i = 0;
  while (i < truth.size()) {
    const NavState& start = truth[i];
    const Timestamp wanted = start.t + Duration::from_s(interval_s);
    const std::size_t j = find_end(truth, i, wanted);
    if (j >= truth.size()) break;
    const NavState& end = truth[j];
    i = j;
    // Two samples beyond the end, so that it is interpolated as well as it can be.
    while (fed < imu.size() && (fed < 2 || imu[fed - 2].t < end.t)) (void)history.add(imu[fed++]);
    bool has_gap = false;
    const std::size_t n = history.interval(start.t, end.t, piece, has_gap);
    Preintegration p;
    if (end.t > wanted + kEndTolerance || n == 0 || has_gap ||
        !p.integrate(std::span<const ImuSample>(piece).first(n), start.bg, start.ba, noise)) {
      ++result.skipped;
      continue;
    }
    Vector15d r;
    const Matrix15d P = p.covariance() + truth_covariance(p, start, end, uncertainty, r);
    accumulate(r.head<9>(), P.topLeftCorner<9, 9>(), result);
  }
  finish(result);
  return result;
}

}  // namespace pled
