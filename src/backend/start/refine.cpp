#include "src/backend/start/refine.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "pled_vins/geometry/so3.hpp"

namespace pled::start {
namespace {

constexpr double kInlierOfSpread = 3.0;
constexpr double kNarrowestInlier = 1.2;  // sigmas
constexpr double kWidestInlier = 2.5;
constexpr double kLargestInverseDepth = 20.0;
constexpr double kHeld = 1e12;  // information of a value that must not move
// The Geman-McClure scale follows the error of the better tracks down: a scale fixed at the assumed
// noise lets a slow object bend the motion when the tracks are better than assumed.
constexpr double kWidestScale = 12;  // sigmas
constexpr double kNarrowestScale = 0.8;
constexpr double kScaleOfSpread = 2.2;
constexpr double kSpreadQuantile = 0.4;
constexpr int kMaxRounds = 25;
constexpr int kMaxAttempts = 5;
constexpr double kFirstDamping = 1e-8;   // the scale lives in directions 1e-6 as stiff as the rest
constexpr double kConvergedGain = 0.02;  // chi^2
constexpr double kBadError = 1e4;        // sigmas^2, of a track behind the camera
// Errors that last from sight to sight do not average out, and they are what a wrong motion leaves.
// Measured on simulated rooms: the scale is off by five to six times what white errors would make
// of it; and what looks white is only partly so.
constexpr double kLastingErrors = 6.0;
constexpr double kChangingErrors = 2.5;
constexpr double kLeastSpread = 0.1;  // sigmas; no tracker is better

Eigen::Matrix<double, 3, 2> tangent_basis(const Eigen::Vector3d& n) {
  const Eigen::Vector3d other =
      std::abs(n.x()) < 0.6 * n.norm() ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  Eigen::Matrix<double, 3, 2> B;
  B.col(0) = n.cross(other).normalized();
  B.col(1) = n.cross(B.col(0)).normalized();
  return B;
}

Eigen::Vector3d position(const MotionState& x, const PathPoint& p) {
  return p.t_s * x.v_0 + 0.5 * p.t_s * p.t_s * x.g_0 + p.alpha;
}

/// d(position of frame k) / d(motion).
Eigen::Matrix<double, 3, kMotionSize> d_position(const MotionState& x, const PathPoint& p) {
  const double half_t2 = 0.5 * p.t_s * p.t_s;
  const double g = x.g_0.norm();
  Eigen::Matrix<double, 3, kMotionSize> J;
  J << p.t_s * Eigen::Matrix3d::Identity(), half_t2 * g * tangent_basis(x.g_0), half_t2 * x.g_0 / g,
      p.d_alpha_d_bg, p.d_alpha_d_ba;
  return J;
}

}  // namespace

MotionState box_plus(const MotionState& x, const MotionVector& d) noexcept {
  MotionState y = x;
  y.v_0 += d.head<3>();
  const double g = x.g_0.norm();
  const Eigen::Vector3d direction = x.g_0 / g + tangent_basis(x.g_0) * d.segment<2>(3);
  y.g_0 = (g + d[kGravityMagnitude]) * direction.normalized();
  y.bg += d.segment<3>(6);
  y.ba += d.segment<3>(9);
  return y;
}

CameraView view(const MotionState& x, const PathPoint& at, const Pose& T_bc) noexcept {
  CameraView v;
  const Eigen::Vector3d lever = at.R_0k * T_bc.p;
  v.R_0c = at.R_0k * T_bc.R();
  v.c_0 = position(x, at) + lever;
  v.d_turn_d_bg = at.R_0k * at.d_theta_d_bg;  // R Exp(d) f = R f + (R d) x (R f)
  v.d_c = d_position(x, at);
  v.d_c.middleCols<3>(6) -= so3::skew(lever) * v.d_turn_d_bg;
  return v;
}

bool reproject(const CameraView& anchor, const CameraView& at, const StartPoint& point,
               const Eigen::Vector2d& seen, Reprojection& out) noexcept {
  // q = rho R_c0 (P - c) = R_c0 (u + rho (c_anchor - c)), scaled so that rho = 0 is allowed.
  const double rho = point.xy_rho.z();
  out.u = anchor.R_0c * Eigen::Vector3d(point.xy_rho.x(), point.xy_rho.y(), 1);
  const Eigen::Vector3d base = anchor.c_0 - at.c_0;
  out.y = out.u + rho * base;
  const Eigen::Vector3d q = at.R_0c.transpose() * out.y;
  if (!(q.z() > 0.01)) return false;
  const double z = 1 / q.z();
  const Eigen::Vector2d xy = q.head<2>() * z;
  out.r = xy - seen;
  out.d_y.row(0) = z * (at.R_0c.col(0) - xy.x() * at.R_0c.col(2)).transpose();
  out.d_y.row(1) = z * (at.R_0c.col(1) - xy.y() * at.R_0c.col(2)).transpose();
  out.d_point.leftCols<2>() = out.d_y * anchor.R_0c.leftCols<2>();
  out.d_point.col(2) = out.d_y * base;
  return true;
}

Eigen::Matrix<double, 2, kMotionSize> d_motion(const CameraView& anchor, const CameraView& at,
                                               const StartPoint& point,
                                               const Reprojection& p) noexcept {
  // The anchor's turn moves u; the turn here moves the camera under y.
  Eigen::Matrix<double, 3, kMotionSize> d_y = point.xy_rho.z() * (anchor.d_c - at.d_c);
  d_y.middleCols<3>(6) += so3::skew(p.y) * at.d_turn_d_bg - so3::skew(p.u) * anchor.d_turn_d_bg;
  return p.d_y * d_y;
}

void MotionRefiner::look(const RigCalibration& rig, const ImuPath& path,
                         const MotionState& x) noexcept {
  for (std::size_t c = 0; c < rig.num_cameras; ++c)
    for (std::size_t k = 0; k < path.size(); ++k)
      views_[c * kMaxFrames + k] = view(x, path[k], rig.cameras[c].T_body_cam);
}

void MotionRefiner::triangulate(const Tracks& tracks) noexcept {
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const std::span<const Sight> sights = tracks.sights(i);
    const CameraView& anchor = view_of(tracks, i, sights.front());
    // Linear in the inverse depth rho: q = R_c0 (u + rho (c_anchor - c)).
    Eigen::Vector3d& point = points_[i].xy_rho;
    const Eigen::Vector3d u = anchor.R_0c * Eigen::Vector3d(point.x(), point.y(), 1);
    double aa = 1e-9;
    double ab = 0;
    for (const Sight& s : sights.subspan(1)) {
      const CameraView& at = view_of(tracks, i, s);
      const Eigen::Vector3d y = at.R_0c.transpose() * u;
      const Eigen::Vector3d d = at.R_0c.transpose() * (anchor.c_0 - at.c_0);
      const Eigen::Vector2d xy = s.ray().head<2>();
      const Eigen::Vector2d a = d.head<2>() - xy * d.z();
      aa += a.squaredNorm();
      ab += a.dot(y.head<2>() - xy * y.z());
    }
    point.z() = std::clamp(-ab / aa, -0.02, 0.5 * kLargestInverseDepth);
  }
}

double MotionRefiner::fit_points(const Tracks& tracks, double sigma, double scale) noexcept {
  double total = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const std::span<const Sight> sights = tracks.sights(i);
    const CameraView& anchor = view_of(tracks, i, sights.front());
    double sum = 0;
    Reprojection p;
    for (int step = 0; step < 3; ++step) {
      Eigen::Matrix3d H = 1e-9 * Eigen::Matrix3d::Identity();
      Eigen::Vector3d b = Eigen::Vector3d::Zero();
      sum = 0;
      for (const Sight& s : sights) {
        if (!reproject(anchor, view_of(tracks, i, s), points_[i], s.ray().head<2>(), p)) {
          sum += kBadError * sigma * sigma;
          continue;
        }
        sum += p.r.squaredNorm();
        H.noalias() += p.d_point.transpose() * p.d_point;
        b.noalias() -= p.d_point.transpose() * p.r;
      }
      if (step == 2) break;
      const Eigen::Vector3d moved = points_[i].xy_rho + H.inverse() * b;
      if (!moved.allFinite()) break;
      points_[i].xy_rho = moved;
      points_[i].xy_rho.z() = std::clamp(moved.z(), -0.02, kLargestInverseDepth);
    }
    const double dof = std::max(1.0, 2.0 * static_cast<double>(sights.size()) - 3.0);
    error_[i] = std::isfinite(sum) ? sum / (sigma * sigma) / dof : kBadError;
    // Geman-McClure over the whole track: a moving object is wrong everywhere.
    total += dof * scale * scale * error_[i] / (scale * scale + error_[i]);
  }
  return total;
}

double MotionRefiner::spread(std::size_t num) noexcept {
  if (num == 0) return 0;
  sorted_ = error_;
  const auto at =
      sorted_.begin() + static_cast<std::ptrdiff_t>(kSpreadQuantile * static_cast<double>(num));
  std::nth_element(sorted_.begin(), at, sorted_.begin() + static_cast<std::ptrdiff_t>(num));
  return std::sqrt(*at);
}

void MotionRefiner::build(const Tracks& tracks, double sigma, double scale, MotionMatrix& H,
                          MotionVector& b) const noexcept {
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const std::span<const Sight> sights = tracks.sights(i);
    const CameraView& anchor = view_of(tracks, i, sights.front());
    const double q = scale * scale / (scale * scale + error_[i]);
    const double w = q * q / (sigma * sigma);
    if (w * sigma * sigma < 1e-3) continue;  // a hundredfold outlier: no use in working it out
    Eigen::Matrix3d Hff = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Matrix<double, kMotionSize, 3> Hxf = Eigen::Matrix<double, kMotionSize, 3>::Zero();
    Eigen::Vector3d bf = Eigen::Vector3d::Zero();
    MotionMatrix Hxx = MotionMatrix::Zero();
    MotionVector bx = MotionVector::Zero();
    Reprojection p;
    for (const Sight& s : sights) {
      const CameraView& at = view_of(tracks, i, s);
      if (!reproject(anchor, at, points_[i], s.ray().head<2>(), p)) continue;
      const Eigen::Matrix<double, 2, kMotionSize> J = d_motion(anchor, at, points_[i], p);
      Hff.noalias() += p.d_point.transpose() * p.d_point;
      Hxf.noalias() += J.transpose() * p.d_point;
      Hxx.noalias() += J.transpose() * J;
      bf.noalias() -= p.d_point.transpose() * p.r;
      bx.noalias() -= J.transpose() * p.r;
    }
    const Eigen::Matrix<double, kMotionSize, 3> G = Hxf * Hff.inverse();
    H += w * (Hxx - G * Hxf.transpose());
    b += w * (bx - G * bf);
  }
}

namespace {

/// Priors on the biases.
void add_priors(const StartBelief& belief, const MotionState& x, MotionMatrix& H, MotionVector& b) {
  const double wg = 1 / (belief.bg_sigma_radps * belief.bg_sigma_radps);
  const double wa = 1 / (belief.ba_sigma_mps2 * belief.ba_sigma_mps2);
  H.diagonal().segment<3>(6).array() += wg;
  H.diagonal().segment<3>(9).array() += wa;
  b.segment<3>(6) -= wg * (x.bg - belief.bg);
  b.segment<3>(9) -= wa * (x.ba - belief.ba);
}

double prior_cost(const StartBelief& belief, const MotionState& x) {
  return ((x.bg - belief.bg) / belief.bg_sigma_radps).squaredNorm() +
         ((x.ba - belief.ba) / belief.ba_sigma_mps2).squaredNorm();
}

double sigma_of(const RigCalibration& rig, const BackendConfig& config) {
  const CameraCalibration& camera = rig.cameras[rig.frame_camera];
  return config.point_sigma_px / (0.5 * (camera.fx_px + camera.fy_px));
}

}  // namespace

bool MotionRefiner::refine(const StartFrames& frames, const ImuHistory& imu,
                           const RigCalibration& rig, const BackendConfig& config,
                           const StartBelief& belief, const Tracks& tracks, ImuPath& path,
                           MotionState& x) noexcept {
  const double sigma = sigma_of(rig, config);
  for (std::size_t i = 0; i < tracks.size(); ++i)
    points_[i].xy_rho = tracks.sights(i).front().ray();
  look(rig, path, x);
  triangulate(tracks);
  (void)fit_points(tracks, sigma, kWidestScale);
  double lambda = kFirstDamping;
  double scale = kWidestScale;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double last_scale = scale;
    scale = std::clamp(kScaleOfSpread * spread(tracks.size()), kNarrowestScale, scale);
    const bool final_scale = scale > 0.95 * last_scale;
    const double cost = fit_points(tracks, sigma, scale) + prior_cost(belief, x);
    MotionMatrix H = MotionMatrix::Zero();
    MotionVector b = MotionVector::Zero();
    build(tracks, sigma, scale, H, b);
    add_priors(belief, x, H, b);
    H.diagonal()[kGravityMagnitude] += kHeld;
    saved_ = points_;
    bool better = false;
    for (int attempt = 0; attempt < kMaxAttempts && !better; ++attempt) {
      MotionMatrix damped = H;
      damped.diagonal() *= 1 + lambda;
      const MotionVector step = damped.ldlt().solve(b);
      if (!step.allFinite()) return false;
      // In units of chi^2: what is left to gain when the valley is as it looks from here.
      if (final_scale && attempt == 0 && step.dot(b) < kConvergedGain) return true;
      const MotionState trial = box_plus(x, step);
      if (path.integrate(frames, imu, trial.bg, trial.ba) != StartRefusal::kNone) return false;
      look(rig, path, trial);
      points_ = saved_;
      triangulate(tracks);  // all depths at once: a step that changes the scale must not look bad
      better = fit_points(tracks, sigma, scale) + prior_cost(belief, trial) < cost;
      lambda = better ? std::max(1e-12, lambda * 0.01) : std::max(1e-8, lambda * 100);
      if (better) x = trial;
    }
    if (better) continue;
    points_ = saved_;
    if (path.integrate(frames, imu, x.bg, x.ba) != StartRefusal::kNone) return false;
    look(rig, path, x);
    if (final_scale) return true;  // no step helps any more
  }
  return false;
}

MotionQuality MotionRefiner::judge(const RigCalibration& rig, const BackendConfig& config,
                                   const StartBelief& belief, const Tracks& tracks,
                                   const ImuPath& path, const MotionState& x) noexcept {
  MotionQuality quality;
  const double sigma = sigma_of(rig, config);
  look(rig, path, x);
  (void)fit_points(tracks, sigma, kWidestInlier);
  const double gate =
      std::clamp(kInlierOfSpread * spread(tracks.size()), kNarrowestInlier, kWidestInlier);
  const double scale = std::max(kNarrowestScale, kScaleOfSpread * spread(tracks.size()));
  std::array<bool, 9> cells{};
  double squares = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    inlier_[i] = error_[i] < gate * gate && points_[i].xy_rho.z() > -0.01;
    if (!inlier_[i]) continue;
    ++quality.inliers;
    squares += error_[i];
    const CameraCalibration& c = rig.cameras[tracks.camera(i)];
    const Sight& s = tracks.sights(i).back();
    const double u = (c.fx_px * static_cast<double>(s.xy[0]) + c.cx_px) / c.width_px;
    const double v = (c.fy_px * static_cast<double>(s.xy[1]) + c.cy_px) / c.height_px;
    const auto third = [](double z) {
      return static_cast<std::size_t>(std::clamp(z * 3, 0.0, 2.99));
    };
    cells[third(v) * 3 + third(u)] = true;
  }
  if (quality.inliers == 0) return quality;
  quality.inlier_share = static_cast<double>(quality.inliers) / static_cast<double>(tracks.size());
  quality.inlier_cells = static_cast<int>(std::count(cells.begin(), cells.end(), true));
  quality.error_sigmas = std::sqrt(squares / static_cast<double>(quality.inliers));

  MotionMatrix H = MotionMatrix::Zero();
  MotionVector b = MotionVector::Zero();
  build(tracks, sigma, scale, H, b);
  // Errors larger than assumed make gravity less certain; smaller ones are not believed.
  const double trust = 1 / std::max(1.0, quality.error_sigmas * quality.error_sigmas);
  H *= trust;
  b *= trust;
  add_priors(belief, x, H, b);
  const MotionMatrix free_covariance = H.inverse();
  quality.gravity_error_mps2 = (free_covariance * b)[kGravityMagnitude];
  quality.gravity_sigma_mps2 = std::sqrt(free_covariance(kGravityMagnitude, kGravityMagnitude));
  H.diagonal()[kGravityMagnitude] += kHeld;
  const MotionMatrix covariance = H.inverse();

  // Scale of the path: s = sum p'^T p_true' / sum |p'|^2 about the mean position.
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < path.size(); ++k)
    mean += position(x, path[k]) / static_cast<double>(path.size());
  double size = 0;
  MotionVector d_scale = MotionVector::Zero();
  for (std::size_t k = 0; k < path.size(); ++k) {
    const Eigen::Vector3d p = position(x, path[k]) - mean;
    size += p.squaredNorm();
    d_scale += d_position(x, path[k]).transpose() * p;
  }
  d_scale /= size;
  quality.scale_sigma = spread_of_inliers(tracks, sigma, quality.error_sigmas) *
                        std::sqrt(d_scale.dot(covariance * d_scale));
  return quality;
}

double MotionRefiner::spread_of_inliers(const Tracks& tracks, double sigma,
                                        double error_sigmas) const noexcept {
  double squares = 0;
  double count = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (!inlier_[i]) continue;
    const std::span<const Sight> sights = tracks.sights(i);
    const CameraView& anchor = view_of(tracks, i, sights.front());
    Reprojection p;
    Eigen::Vector2d last;
    for (std::size_t k = 0; k < sights.size(); ++k) {
      const Eigen::Vector2d seen = sights[k].ray().head<2>();
      if (!reproject(anchor, view_of(tracks, i, sights[k]), points_[i], seen, p)) break;
      if (k > 0) squares += (p.r - last).squaredNorm();
      if (k > 0) count += 4;  // two axes, each difference with twice the variance
      last = p.r;
    }
  }
  const double all = error_sigmas * error_sigmas;
  const double white = std::min(all, squares / (std::max(count, 1.0) * sigma * sigma));
  return std::max(kLeastSpread, std::sqrt(kChangingErrors * kChangingErrors * white +
                                          kLastingErrors * kLastingErrors * (all - white)));
}

}  // namespace pled::start
