#include "src/backend/start/linear.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace pled::start {
namespace {

constexpr int kDraws = 60;
constexpr std::size_t kSubset = 6;
constexpr int kDepthRounds = 3;
constexpr double kNearest_m = 0.3;
constexpr double kFarthest_m = 100.0;

/// Camera centre of frame k: T x + s with T = [t I, t^2/2 I].
Eigen::Vector3d fixed_part(const PathPoint& p, const Eigen::Vector3d& p_bc) {
  return p.alpha + p.R_0k * p_bc;
}
Eigen::Vector3d centre(const PathPoint& p, const Eigen::Vector3d& p_bc, const Vector6d& x) {
  return p.t_s * x.head<3>() + 0.5 * p.t_s * p.t_s * x.tail<3>() + fixed_part(p, p_bc);
}

}  // namespace

std::optional<Vector6d> solve_with_gravity(const Matrix6d& H, const Vector6d& b,
                                           double gravity_mps2) noexcept {
  const Eigen::Matrix3d Hvv = H.topLeftCorner<3, 3>();
  const Eigen::Matrix3d Hvg = H.topRightCorner<3, 3>();
  const Eigen::LLT<Eigen::Matrix3d> llt(Hvv);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const Eigen::Matrix3d S = H.bottomRightCorner<3, 3>() - Hvg.transpose() * llt.solve(Hvg);
  const Eigen::Vector3d r = b.tail<3>() - Hvg.transpose() * llt.solve(b.head<3>());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(S);
  if (eigen.info() != Eigen::Success) return std::nullopt;
  const Eigen::Vector3d& l = eigen.eigenvalues();
  const Eigen::Vector3d c = eigen.eigenvectors().transpose() * r;
  // |g(lambda)| falls monotonously right of -l_min: bisect for |g| = gravity.
  const auto length = [&](double lambda) {
    return (c.array() / (l.array() + lambda)).matrix().norm();
  };
  double lo = -l[0] * (1 - 1e-12) + 1e-300;
  double hi = -l[0] + c.norm() / gravity_mps2 + std::abs(l[0]) * 1e-9;
  if (!(length(hi) <= gravity_mps2 * (1 + 1e-6)) || !std::isfinite(hi)) return std::nullopt;
  for (int i = 0; i < 60; ++i) {
    const double mid = 0.5 * (lo + hi);
    (length(mid) > gravity_mps2 ? lo : hi) = mid;
  }
  Vector6d x;
  x.tail<3>() = eigen.eigenvectors() * (c.array() / (l.array() + hi)).matrix();
  x.head<3>() = llt.solve(b.head<3>() - Hvg * x.tail<3>());
  if (!x.allFinite()) return std::nullopt;
  return x;
}

void LinearSearch::prepare(std::size_t i, const Tracks& tracks, const ImuPath& path,
                           const RigCalibration& rig) noexcept {
  // Residual of sight k: A (P - T x - s), A = I - u u^T. P = M^-1 (sum A T x + sum A s), M = sum A.
  const Pose& T_bc = rig.cameras[tracks.camera(i)].T_body_cam;
  const Eigen::Matrix3d R_bc = T_bc.R();
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 6> AT = Eigen::Matrix<double, 3, 6>::Zero();
  Eigen::Vector3d As = Eigen::Vector3d::Zero();
  Equations& e = equations_[i];
  e.H.setZero();
  e.b.setZero();
  Eigen::Vector3d mean_u = Eigen::Vector3d::Zero();
  Vector6d mean_c_x = Vector6d::Zero();  // diagonal of the mean T
  Eigen::Vector3d mean_s = Eigen::Vector3d::Zero();
  const double n = static_cast<double>(tracks.sights(i).size());
  for (const Sight& sight : tracks.sights(i)) {
    const PathPoint& p = path[sight.frame];
    const Eigen::Vector3d u = p.R_0k * R_bc * sight.ray().normalized();
    const Eigen::Vector3d s = fixed_part(p, T_bc.p);
    const Eigen::Matrix3d A = Eigen::Matrix3d::Identity() - u * u.transpose();
    Eigen::Matrix<double, 3, 6> T;
    T << p.t_s * Eigen::Matrix3d::Identity(), 0.5 * p.t_s * p.t_s * Eigen::Matrix3d::Identity();
    M += A;
    AT += A * T;
    As += A * s;
    e.H += T.transpose() * A * T;
    e.b -= T.transpose() * A * s;
    mean_u += u / n;
    mean_s += s / n;
    mean_c_x.head<3>().array() += p.t_s / n;
    mean_c_x.tail<3>().array() += 0.5 * p.t_s * p.t_s / n;
  }
  M.diagonal().array() += 1e-9 * n;
  const Eigen::Matrix3d M_inverse = M.inverse();
  e.H -= AT.transpose() * M_inverse * AT;
  e.b += AT.transpose() * M_inverse * As;
  Eigen::Matrix<double, 3, 6> mean_T;
  mean_T << mean_c_x[0] * Eigen::Matrix3d::Identity(), mean_c_x[3] * Eigen::Matrix3d::Identity();
  mean_u.normalize();
  e.depth_a = (mean_u.transpose() * (M_inverse * AT - mean_T)).transpose();
  e.depth_c = mean_u.dot(M_inverse * As - mean_s);
  e.valid = e.H.allFinite() && e.b.allFinite() && e.depth_a.allFinite();
}

std::optional<Vector6d> LinearSearch::solve(const std::size_t* chosen, std::size_t num,
                                            double gravity_mps2) const noexcept {
  std::optional<Vector6d> x;
  for (int round = 0; round < kDepthRounds; ++round) {
    Matrix6d H = Matrix6d::Zero();
    Vector6d b = Vector6d::Zero();
    for (std::size_t k = 0; k < num; ++k) {
      const Equations& e = equations_[chosen[k]];
      double depth = 1.0;
      if (x) depth = std::clamp(e.depth_a.dot(*x) + e.depth_c, kNearest_m, kFarthest_m);
      H += e.H / (depth * depth);
      b += e.b / (depth * depth);
    }
    x = solve_with_gravity(H, b, gravity_mps2);
    if (!x) return std::nullopt;
  }
  return x;
}

double LinearSearch::score(const Vector6d& x, const Tracks& tracks, const ImuPath& path,
                           const RigCalibration& rig, double gate) noexcept {
  double total = 0;
  for (std::size_t k = 0; k < num_usable_; ++k) {
    const std::size_t i = usable_[k];
    const Pose& T_bc = rig.cameras[tracks.camera(i)].T_body_cam;
    const Eigen::Matrix3d R_bc = T_bc.R();
    const std::span<const Sight> sights = tracks.sights(i);
    const PathPoint& anchor = path[sights.front().frame];
    const Eigen::Vector3d u = anchor.R_0k * R_bc * sights.front().ray();
    const Eigen::Vector3d c = centre(anchor, T_bc.p, x);
    // q = y + rho d in the camera of sight k: linear in the inverse depth rho.
    std::array<Eigen::Vector3d, kMaxFrames> y;
    std::array<Eigen::Vector3d, kMaxFrames> d;
    double aa = 1e-12;
    double ab = 0;
    for (std::size_t n = 1; n < sights.size(); ++n) {
      const PathPoint& p = path[sights[n].frame];
      const Eigen::Matrix3d R_c0 = (p.R_0k * R_bc).transpose();
      y[n] = R_c0 * u;
      d[n] = R_c0 * (c - centre(p, T_bc.p, x));
      const Eigen::Vector2d xy = sights[n].ray().head<2>();
      const Eigen::Vector2d a = d[n].head<2>() - xy * d[n].z();
      const Eigen::Vector2d b = y[n].head<2>() - xy * y[n].z();
      aa += a.squaredNorm();
      ab += a.dot(b);
    }
    const double rho = std::clamp(-ab / aa, 0.0, 1.0 / 0.1);
    double sum = 0;
    for (std::size_t n = 1; n < sights.size(); ++n) {
      const Eigen::Vector3d q = y[n] + rho * d[n];
      const Eigen::Vector2d r = q.head<2>() / q.z() - sights[n].ray().head<2>();
      sum += q.z() > 0.05 ? r.squaredNorm() : 1.0;
    }
    const double share = sum / static_cast<double>(sights.size() - 1) / (gate * gate);
    agrees_[i] = share < 1.0;
    total += agrees_[i] ? share : 1.0;
  }
  return total;
}

std::optional<Vector6d> LinearSearch::best(const Tracks& tracks, const ImuPath& path,
                                           const RigCalibration& rig,
                                           const BackendConfig& config) noexcept {
  num_usable_ = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    prepare(i, tracks, path, rig);
    if (equations_[i].valid) usable_[num_usable_++] = i;
  }
  if (num_usable_ < kSubset) return std::nullopt;
  const CameraCalibration& camera = rig.cameras[rig.frame_camera];
  // Both axes, with room for what is left of the gyro bias.
  const double gate = 4.0 * config.point_sigma_px / (0.5 * (camera.fx_px + camera.fy_px));
  std::mt19937_64 random(2);
  std::optional<Vector6d> best;
  double best_score = std::numeric_limits<double>::infinity();
  const auto try_out = [&](const std::size_t* chosen, std::size_t num) {
    const std::optional<Vector6d> x = solve(chosen, num, config.gravity_mps2);
    if (!x) return;
    const double s = score(*x, tracks, path, rig, gate);
    if (!(s < best_score)) return;
    best_score = s;
    best = x;
  };
  std::array<std::size_t, kMaxTracks> chosen{};
  for (int draw = 0; draw < kDraws; ++draw) {
    for (std::size_t k = 0; k < kSubset; ++k) {  // partial shuffle: no index twice
      std::swap(usable_[k], usable_[k + random() % (num_usable_ - k)]);
      chosen[k] = usable_[k];
    }
    try_out(chosen.data(), kSubset);
  }
  for (int polish = 0; polish < 3 && best; ++polish) {
    std::size_t num = 0;
    best_score = score(*best, tracks, path, rig, gate);
    for (std::size_t k = 0; k < num_usable_; ++k)
      if (agrees_[usable_[k]]) chosen[num++] = usable_[k];
    if (num >= kSubset) try_out(chosen.data(), num);
  }
  return best;
}

}  // namespace pled::start
