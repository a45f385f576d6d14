#include "pled_vins/imu/preintegration.hpp"

#include <cmath>

#include <Eigen/Cholesky>

#include "pled_vins/geometry/so3.hpp"
#include "src/imu/imu_step.hpp"

namespace pled {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// Places in the tangent: p, theta, v, bg, ba.
constexpr int kP = 0;
constexpr int kTheta = 3;
constexpr int kV = 6;
constexpr int kBg = 9;
constexpr int kBa = 12;

/// Derivatives of one step's end (p, theta, v) by its start's errors.
using Transition = Eigen::Matrix<double, 9, 15>;

/// What one step adds, in the body frame of the step's start.
struct Step {
  double h_s = 0.0;
  Quaterniond dq;  ///< end from start
  Vector3d dv;     ///< m/s
  Vector3d dp;     ///< m, beyond v h
  Transition f;    ///< with delta v, delta p in the step's start frame
};

struct Signal {
  Vector3d w0, wm, w1;  ///< bias-free rate at start, middle, end, rad/s
  Vector3d a0, am, a1;  ///< bias-free specific force, m/s^2
};

bool finite(const ImuSample& s) noexcept {
  return imu_step::gyro(s).allFinite() && imu_step::accel(s).allFinite();
}

bool positive(const ImuNoise& n) noexcept {
  return n.gyro_density > 0.0 && n.accel_density > 0.0 && n.gyro_walk > 0.0 && n.accel_walk > 0.0 &&
         std::isfinite(n.gyro_density + n.accel_density + n.gyro_walk + n.accel_walk);
}

Signal signal_of(std::span<const ImuSample> s, std::size_t i, const Vector3d& bg,
                 const Vector3d& ba) noexcept {
  const ImuSample* before = i > 0 ? &s[i - 1] : nullptr;
  const ImuSample* after = i + 2 < s.size() ? &s[i + 2] : nullptr;
  const imu_step::Weights w = imu_step::weights_at(0.5, before, s[i], s[i + 1], after);
  return {imu_step::gyro(s[i]) - bg,
          imu_step::blend(w, before, s[i], s[i + 1], after, imu_step::gyro) - bg,
          imu_step::gyro(s[i + 1]) - bg,
          imu_step::accel(s[i]) - ba,
          imu_step::blend(w, before, s[i], s[i + 1], after, imu_step::accel) - ba,
          imu_step::accel(s[i + 1]) - ba};
}

/// One step: f(t) = R(t) a(t) is taken as the parabola through start, middle and end, so that
/// dv = h/6 (f0 + 4 fm + f1) and dp = h^2 (f0/6 + fm/3).
Step step_of(const Signal& s, double h) noexcept {
  Step out;
  out.h_s = h;
  const Vector3d phi_m = imu_step::half_rotation(s.w0, s.wm, s.w1, h);
  const Vector3d phi = imu_step::full_rotation(s.w0, s.wm, s.w1, h);
  out.dq = so3::exp(phi);
  const Matrix3d Rm = so3::exp(phi_m).toRotationMatrix();
  const Matrix3d R1 = out.dq.toRotationMatrix();
  const Vector3d fm = Rm * s.am;
  out.dv = h / 6.0 * (s.a0 + 4.0 * fm + R1 * s.a1);
  out.dp = h * h * (s.a0 / 6.0 + fm / 3.0);

  // Errors: theta on the right of R at start, middle (m) and end (1).
  const Matrix3d thetam_bg = -0.5 * h * so3::right_jacobian(phi_m);
  const Matrix3d theta1_bg = -h * so3::right_jacobian(phi);
  const Matrix3d f0_theta = -so3::skew(s.a0);
  const Matrix3d fm_thetam = -Rm * so3::skew(s.am);
  const Matrix3d f1_theta1 = -R1 * so3::skew(s.a1);
  const Matrix3d fm_theta = fm_thetam * Rm.transpose();
  const Matrix3d f1_theta = f1_theta1 * R1.transpose();
  Transition& f = out.f;
  f.setZero();
  f.block<3, 3>(kP, kP).setIdentity();
  f.block<3, 3>(kP, kTheta) = h * h * (f0_theta / 6.0 + fm_theta / 3.0);
  f.block<3, 3>(kP, kV) = h * Matrix3d::Identity();
  f.block<3, 3>(kP, kBg) = h * h / 3.0 * fm_thetam * thetam_bg;
  f.block<3, 3>(kP, kBa) = -h * h * (Matrix3d::Identity() / 6.0 + Rm / 3.0);
  f.block<3, 3>(kTheta, kTheta) = R1.transpose();
  f.block<3, 3>(kTheta, kBg) = theta1_bg;
  f.block<3, 3>(kV, kTheta) = h / 6.0 * (f0_theta + 4.0 * fm_theta + f1_theta);
  f.block<3, 3>(kV, kV).setIdentity();
  f.block<3, 3>(kV, kBg) = h / 6.0 * (4.0 * fm_thetam * thetam_bg + f1_theta1 * theta1_bg);
  f.block<3, 3>(kV, kBa) = -h / 6.0 * (Matrix3d::Identity() + 4.0 * Rm + R1);
  return out;
}

/// Turns the blocks that mix the step's frame with that of the interval's start: R takes the
/// former to the latter.
void rotate_to_interval(const Matrix3d& R, Transition& f) noexcept {
  for (const int row : {kP, kV}) {
    for (const int column : {kTheta, kBg, kBa}) {
      const Matrix3d block = R * f.block<3, 3>(row, column);
      f.block<3, 3>(row, column) = block;
    }
  }
}

/// P <- F P F^T + Q. White noise of density s over a step of h: angle s^2 h, velocity s^2 h,
/// position s^2 h^3 / 3 and s^2 h^2 / 2 with velocity; each sample counts once, so that the sum
/// over an interval is s^2 T whatever the rate. Isotropic, hence free of R.
void add_step(const Transition& f, double h, const ImuNoise& noise, Matrix15d& P) noexcept {
  const Eigen::Matrix<double, 9, 15> fP = f * P;
  P.topLeftCorner<9, 9>() = fP * f.transpose();
  P.topRightCorner<9, 6>() = fP.rightCols<6>();
  P.bottomLeftCorner<6, 9>() = fP.rightCols<6>().transpose();
  const double accel2 = noise.accel_density * noise.accel_density;
  P.diagonal().segment<3>(kP).array() += accel2 * h * h * h / 3.0;
  P.diagonal().segment<3>(kTheta).array() += noise.gyro_density * noise.gyro_density * h;
  P.diagonal().segment<3>(kV).array() += accel2 * h;
  P.diagonal().segment<3>(kBg).array() += noise.gyro_walk * noise.gyro_walk * h;
  P.diagonal().segment<3>(kBa).array() += noise.accel_walk * noise.accel_walk * h;
  for (int i = 0; i < 3; ++i) {
    P(kP + i, kV + i) += accel2 * h * h / 2.0;
    P(kV + i, kP + i) += accel2 * h * h / 2.0;
  }
}

}  // namespace

bool Preintegration::integrate(std::span<const ImuSample> samples, const Vector3d& bg,
                               const Vector3d& ba, const ImuNoise& noise) noexcept {
  *this = Preintegration{};
  if (samples.size() < 2 || !bg.allFinite() || !ba.allFinite() || !positive(noise)) return false;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!finite(samples[i]) || (i > 0 && !(samples[i].t > samples[i - 1].t))) return false;
  }
  gravity_ = {0.0, 0.0, -noise.gravity_mps2};
  bg_ = bg;
  ba_ = ba;
  // d (p, theta, v) / d (bg, ba): the transition's product, its bias columns.
  Eigen::Matrix<double, 9, 6> J = Eigen::Matrix<double, 9, 6>::Zero();
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    const double h = (samples[i + 1].t - samples[i].t).seconds();
    Step step = step_of(signal_of(samples, i, bg, ba), h);
    const Matrix3d R = delta_q_.toRotationMatrix();
    rotate_to_interval(R, step.f);
    add_step(step.f, h, noise, covariance_);
    const Eigen::Matrix<double, 9, 6> J_end = step.f.leftCols<9>() * J + step.f.rightCols<6>();
    J = J_end;
    delta_p_ += delta_v_ * h + R * step.dp;
    delta_v_ += R * step.dv;
    delta_q_ = (delta_q_ * step.dq).normalized();
  }
  d_p_d_bg_ = J.block<3, 3>(kP, 0);
  d_p_d_ba_ = J.block<3, 3>(kP, 3);
  d_q_d_bg_ = J.block<3, 3>(kTheta, 0);
  d_v_d_bg_ = J.block<3, 3>(kV, 0);
  d_v_d_ba_ = J.block<3, 3>(kV, 3);
  dt_s_ = (samples.back().t - samples.front().t).seconds();
  return finish();
}

bool Preintegration::finish() noexcept {
  const Matrix15d symmetric = 0.5 * (covariance_ + covariance_.transpose());
  covariance_ = symmetric;
  const Eigen::LLT<Matrix15d> llt(covariance_);
  sqrt_information_.setIdentity();
  llt.matrixL().solveInPlace(sqrt_information_);
  const bool ok = llt.info() == Eigen::Success && sqrt_information_.allFinite() &&
                  delta_p_.allFinite() && delta_v_.allFinite();
  if (!ok) *this = Preintegration{};
  return ok;
}

Quaterniond Preintegration::delta_q(const Vector3d& bg) const noexcept {
  return (delta_q_ * so3::exp(d_q_d_bg_ * (bg - bg_))).normalized();
}

Vector3d Preintegration::delta_v(const Vector3d& bg, const Vector3d& ba) const noexcept {
  return delta_v_ + d_v_d_bg_ * (bg - bg_) + d_v_d_ba_ * (ba - ba_);
}

Vector3d Preintegration::delta_p(const Vector3d& bg, const Vector3d& ba) const noexcept {
  return delta_p_ + d_p_d_bg_ * (bg - bg_) + d_p_d_ba_ * (ba - ba_);
}

NavState Preintegration::predict(const NavState& start) const noexcept {
  NavState end = start;
  end.t = start.t + Duration::from_s(dt_s_);
  end.p_wb = start.p_wb + start.v_wb * dt_s_ + 0.5 * dt_s_ * dt_s_ * gravity_ +
             start.q_wb * delta_p(start.bg, start.ba);
  end.q_wb = (start.q_wb * delta_q(start.bg)).normalized();
  end.v_wb = start.v_wb + dt_s_ * gravity_ + start.q_wb * delta_v(start.bg, start.ba);
  return end;
}

void Preintegration::residual(const NavState& i, const NavState& j, Vector15d& r,
                              Matrix15d* d_r_d_i, Matrix15d* d_r_d_j) const noexcept {
  const Matrix3d R_it = i.q_wb.conjugate().toRotationMatrix();
  const Vector3d p_ij = R_it * (j.p_wb - i.p_wb - i.v_wb * dt_s_ - 0.5 * dt_s_ * dt_s_ * gravity_);
  const Vector3d v_ij = R_it * (j.v_wb - i.v_wb - dt_s_ * gravity_);
  const Vector3d r_theta = so3::log(delta_q(i.bg).conjugate() * (i.q_wb.conjugate() * j.q_wb));
  r.segment<3>(kP) = p_ij - delta_p(i.bg, i.ba);
  r.segment<3>(kTheta) = r_theta;
  r.segment<3>(kV) = v_ij - delta_v(i.bg, i.ba);
  r.segment<3>(kBg) = j.bg - i.bg;
  r.segment<3>(kBa) = j.ba - i.ba;
  if (d_r_d_i == nullptr && d_r_d_j == nullptr) return;
  const Matrix3d jr_inverse = so3::right_jacobian_inverse(r_theta);
  if (d_r_d_i != nullptr) {
    Matrix15d& d = *d_r_d_i;
    d.setZero();
    d.block<3, 3>(kP, kP) = -R_it;
    d.block<3, 3>(kP, kTheta) = so3::skew(p_ij);
    d.block<3, 3>(kP, kV) = -dt_s_ * R_it;
    d.block<3, 3>(kP, kBg) = -d_p_d_bg_;
    d.block<3, 3>(kP, kBa) = -d_p_d_ba_;
    d.block<3, 3>(kTheta, kTheta) = -jr_inverse * (j.q_wb.conjugate() * i.q_wb).toRotationMatrix();
    // dq(bg + b) = dq(bg) Exp(J_r(D (bg - bg0)) D b), moved through the residual's rotation.
    d.block<3, 3>(kTheta, kBg) = -jr_inverse * so3::exp(-r_theta).toRotationMatrix() *
                                 so3::right_jacobian(d_q_d_bg_ * (i.bg - bg_)) * d_q_d_bg_;
    d.block<3, 3>(kV, kTheta) = so3::skew(v_ij);
    d.block<3, 3>(kV, kV) = -R_it;
    d.block<3, 3>(kV, kBg) = -d_v_d_bg_;
    d.block<3, 3>(kV, kBa) = -d_v_d_ba_;
    d.block<6, 6>(kBg, kBg) = -Eigen::Matrix<double, 6, 6>::Identity();
  }
  if (d_r_d_j != nullptr) {
    Matrix15d& d = *d_r_d_j;
    d.setZero();
    d.block<3, 3>(kP, kP) = R_it;
    d.block<3, 3>(kTheta, kTheta) = jr_inverse;
    d.block<3, 3>(kV, kV) = R_it;
    d.block<6, 6>(kBg, kBg).setIdentity();
  }
}

NavState box_plus(const NavState& x, const Vector15d& d) noexcept {
  NavState y = x;
  y.p_wb += d.segment<3>(kP);
  y.q_wb = (x.q_wb * so3::exp(d.segment<3>(kTheta))).normalized();
  y.v_wb += d.segment<3>(kV);
  y.bg += d.segment<3>(kBg);
  y.ba += d.segment<3>(kBa);
  return y;
}

Vector15d box_minus(const NavState& y, const NavState& x) noexcept {
  Vector15d d;
  d.segment<3>(kP) = y.p_wb - x.p_wb;
  d.segment<3>(kTheta) = so3::log(x.q_wb.conjugate() * y.q_wb);
  d.segment<3>(kV) = y.v_wb - x.v_wb;
  d.segment<3>(kBg) = y.bg - x.bg;
  d.segment<3>(kBa) = y.ba - x.ba;
  return d;
}

}  // namespace pled
