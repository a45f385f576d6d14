#include "src/backend/start/imu_path.hpp"

#include <algorithm>
#include <cmath>

#include "pled_vins/geometry/so3.hpp"

namespace pled::start {
namespace {

Eigen::Vector3d gyro(const ImuSample& s) {
  return {s.gyro_radps[0], s.gyro_radps[1], s.gyro_radps[2]};
}
Eigen::Vector3d accel(const ImuSample& s) {
  return {s.accel_mps2[0], s.accel_mps2[1], s.accel_mps2[2]};
}

/// Specific force in frame 0 and its derivatives at one instant.
struct Force {
  Eigen::Vector3d value;
  Eigen::Matrix3d d_bg;
  Eigen::Matrix3d d_ba;
};
Force force(const Eigen::Matrix3d& R, const Eigen::Matrix3d& d_theta_d_bg,
            const Eigen::Vector3d& accel_b) {
  return {R * accel_b, -R * so3::skew(accel_b) * d_theta_d_bg, -R};
}

}  // namespace

void ImuPath::advance(PathPoint& x, const ImuSample& a, const ImuSample& b,
                      const Eigen::Vector3d& bg, const Eigen::Vector3d& ba) const noexcept {
  const double dt = (b.t - a.t).seconds();
  const Eigen::Vector3d phi = (0.5 * (gyro(a) + gyro(b)) - bg) * dt;
  const Eigen::Matrix3d E_half = so3::exp(0.5 * phi).toRotationMatrix();
  const Eigen::Matrix3d R_half = x.R_0k * E_half;
  const Eigen::Matrix3d R_end = R_half * E_half;
  // d Exp(s (w - bg) dt) = -J_r(s phi) s dt, after carrying the old tangent over.
  const Eigen::Matrix3d J_half =
      E_half.transpose() * x.d_theta_d_bg - so3::right_jacobian(0.5 * phi) * (0.5 * dt);
  const Eigen::Matrix3d J_end =
      (E_half * E_half).transpose() * x.d_theta_d_bg - so3::right_jacobian(phi) * dt;
  const Force f0 = force(x.R_0k, x.d_theta_d_bg, accel(a) - ba);
  const Force f1 = force(R_half, J_half, 0.5 * (accel(a) + accel(b)) - ba);
  const Force f2 = force(R_end, J_end, accel(b) - ba);
  const double dt2 = dt * dt / 6.0;  // Simpson: double integral weights 1/6, 1/3, 0
  x.alpha += x.beta * dt + dt2 * (f0.value + 2.0 * f1.value);
  x.d_alpha_d_bg += x.d_beta_d_bg * dt + dt2 * (f0.d_bg + 2.0 * f1.d_bg);
  x.d_alpha_d_ba += x.d_beta_d_ba * dt + dt2 * (f0.d_ba + 2.0 * f1.d_ba);
  x.beta += dt / 6.0 * (f0.value + 4.0 * f1.value + f2.value);
  x.d_beta_d_bg += dt / 6.0 * (f0.d_bg + 4.0 * f1.d_bg + f2.d_bg);
  x.d_beta_d_ba += dt / 6.0 * (f0.d_ba + 4.0 * f1.d_ba + f2.d_ba);
  x.R_0k = R_end;
  x.d_theta_d_bg = J_end;
  x.t_s += dt;
}

StartRefusal ImuPath::integrate(const StartFrames& frames, const ImuHistory& imu,
                                const Eigen::Vector3d& bg, const Eigen::Vector3d& ba) noexcept {
  PathPoint x;
  points_[0] = x;
  size_ = 1;
  double count = 0;
  double gyro_squares = 0;
  double accel_squares = 0;
  mean_gyro_.setZero();
  mean_accel_.setZero();
  const auto add_up = [&](const ImuSample& s) {
    mean_gyro_ += gyro(s);
    mean_accel_ += accel(s);
    gyro_squares += gyro(s).squaredNorm();
    accel_squares += accel(s).squaredNorm();
    count += 1;
  };
  for (std::size_t k = 1; k < frames.size(); ++k) {
    bool has_gap = false;
    const std::size_t n = imu.interval(frames[k - 1].t, frames[k].t, buffer_, has_gap);
    if (n < 2) return StartRefusal::kNoImu;
    if (has_gap) return StartRefusal::kImuGap;
    for (std::size_t i = 1; i < n; ++i) {
      advance(x, buffer_[i - 1], buffer_[i], bg, ba);
      add_up(buffer_[i]);
    }
    points_[size_++] = x;
  }
  if (count > 0) {
    mean_gyro_ /= count;
    mean_accel_ /= count;
    gyro_std_ = std::sqrt(std::max(0.0, gyro_squares / count - mean_gyro_.squaredNorm()));
    accel_std_ = std::sqrt(std::max(0.0, accel_squares / count - mean_accel_.squaredNorm()));
  }
  return StartRefusal::kNone;
}

}  // namespace pled::start
