#include "src/backend/start/gyro_bias.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "pled_vins/geometry/so3.hpp"

namespace pled::start {
namespace {

constexpr int kDraws = 80;
constexpr std::size_t kSubset = 6;
constexpr int kSubsetSteps = 3;
constexpr int kPolishSteps = 5;
constexpr std::size_t kMinPairsSeen = 3;
constexpr double kGateSigmas = 4.0;

}  // namespace

void GyroBiasSearch::choose_pairs(const ImuPath& path) noexcept {
  num_pairs_ = 0;
  const double half_s = 0.5 * path[path.size() - 1].t_s;
  const std::size_t last = path.size() - 1;
  for (std::size_t p = 0; p < kPairs; ++p) {
    const double start_s = half_s * static_cast<double>(p) / static_cast<double>(kPairs - 1);
    std::size_t i = 0;
    while (i < last && path[i].t_s < start_s - 1e-6) ++i;
    std::size_t j = i;
    while (j < last && path[j].t_s < path[i].t_s + half_s - 1e-6) ++j;
    const bool repeated = num_pairs_ > 0 && pairs_[num_pairs_ - 1].first == i;
    if (j == i || repeated) continue;
    // R Exp(D bg) f = R f + (R D bg) x (R f).
    pairs_[num_pairs_++] = {i, j, path[i].R_0k * path[i].d_theta_d_bg,
                            path[j].R_0k * path[j].d_theta_d_bg};
  }
}

void GyroBiasSearch::match(const Tracks& tracks, const ImuPath& path,
                           const RigCalibration& rig) noexcept {
  num_usable_ = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const Eigen::Matrix3d R_bc = rig.cameras[tracks.camera(i)].T_body_cam.R();
    std::size_t seen = 0;
    for (std::size_t p = 0; p < num_pairs_; ++p) {
      Match& m = matches_[p * kMaxTracks + i];
      const Sight* a = nullptr;
      const Sight* b = nullptr;
      for (const Sight& s : tracks.sights(i)) {
        if (s.frame == pairs_[p].first) a = &s;
        if (s.frame == pairs_[p].second) b = &s;
      }
      m.seen = a != nullptr && b != nullptr;
      if (!m.seen) continue;
      m.u = path[pairs_[p].first].R_0k * R_bc * a->ray().normalized();
      m.v = path[pairs_[p].second].R_0k * R_bc * b->ray().normalized();
      ++seen;
    }
    weight_[i] = 1;
    if (seen >= std::min(kMinPairsSeen, num_pairs_)) usable_[num_usable_++] = i;
  }
}

void GyroBiasSearch::turned(std::size_t pair, std::size_t track, const Eigen::Vector3d& bg,
                            Eigen::Vector3d& u, Eigen::Vector3d& v) const noexcept {
  const Match& m = at(pair, track);
  const Eigen::Vector3d a = pairs_[pair].W_first * bg;
  const Eigen::Vector3d b = pairs_[pair].W_second * bg;
  u = m.u + a.cross(m.u + 0.5 * a.cross(m.u));  // Exp to second order: the rest is < 1e-4 rad
  v = m.v + b.cross(m.v + 0.5 * b.cross(m.v));
}

void GyroBiasSearch::step(std::span<const std::size_t> chosen, double sigma, double prior_sigma,
                          Directions& directions, Eigen::Vector3d& bg) const noexcept {
  Eigen::Matrix3d H = Eigen::Matrix3d::Identity() / (prior_sigma * prior_sigma);
  Eigen::Vector3d g = -bg / (prior_sigma * prior_sigma);
  for (std::size_t p = 0; p < num_pairs_; ++p) {
    Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
    Eigen::Vector3d u, v;
    for (const std::size_t i : chosen) {
      if (!at(p, i).seen) continue;
      turned(p, i, bg, u, v);
      const Eigen::Vector3d n = u.cross(v);
      N += weight_[i] * n * n.transpose();
    }
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
    eigen.computeDirect(N);
    const Eigen::Vector3d t = eigen.eigenvectors().col(0);
    const Eigen::Matrix<double, 3, 2> B = eigen.eigenvectors().rightCols<2>();
    if (!t.allFinite()) continue;
    directions[p] = t;
    Eigen::Matrix2d Htt = Eigen::Matrix2d::Identity();  // keeps a free direction where it is
    Eigen::Matrix<double, 3, 2> Hbt = Eigen::Matrix<double, 3, 2>::Zero();
    Eigen::Vector2d gt = Eigen::Vector2d::Zero();
    for (const std::size_t i : chosen) {
      if (!at(p, i).seen) continue;
      turned(p, i, bg, u, v);
      const double scale = 1 / std::max(1e-2, t.cross(u).norm());
      const Eigen::Vector3d n = u.cross(v) * scale;
      const double r = t.dot(n);
      // d (t . u x v) with du = a x u, dv = b x v.
      const double uv = u.dot(v);
      const Eigen::RowVector3d d_b =
          scale * ((t.dot(u) * v - uv * t).transpose() * pairs_[p].W_first +
                   (uv * t - t.dot(v) * u).transpose() * pairs_[p].W_second);
      const Eigen::RowVector2d d_t = n.transpose() * B;
      const double w = weight_[i] / (2 * sigma * sigma);
      H += w * d_b.transpose() * d_b;
      Hbt += w * d_b.transpose() * d_t;
      Htt += w * d_t.transpose() * d_t;
      g -= w * r * d_b.transpose();
      gt -= w * r * d_t.transpose();
    }
    const Eigen::Matrix2d Htt_inverse = Htt.inverse();
    H -= Hbt * Htt_inverse * Hbt.transpose();
    g -= Hbt * Htt_inverse * gt;
    directions[p] = (t + B * (Htt_inverse * gt)).normalized();
  }
  const Eigen::Vector3d d = H.ldlt().solve(g);
  if (d.allFinite()) bg += d;
}

double GyroBiasSearch::score(const Eigen::Vector3d& bg, const Directions& directions,
                             double gate) noexcept {
  double total = 0;
  for (std::size_t k = 0; k < num_usable_; ++k) {
    const std::size_t i = usable_[k];
    double sum = 0;
    double count = 0;
    Eigen::Vector3d u, v;
    for (std::size_t p = 0; p < num_pairs_; ++p) {
      if (!at(p, i).seen) continue;
      turned(p, i, bg, u, v);
      const Eigen::Vector3d plane = directions[p].cross(u);
      const double r = plane.dot(v) / std::max(1e-2, plane.norm());
      sum += r * r;
      count += 1;
    }
    error_[i] = sum / std::max(1.0, count);
    total += std::min(error_[i] / (gate * gate), 1.0);
  }
  return total;
}

Eigen::Vector3d GyroBiasSearch::find(const Tracks& tracks, const ImuPath& path,
                                     const RigCalibration& rig, const BackendConfig& config,
                                     double prior_sigma) noexcept {
  choose_pairs(path);
  match(tracks, path, rig);
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  if (num_usable_ < kSubset) return best;
  const double sigma = config.point_sigma_px / mean_focal_px(rig.cameras[rig.frame_camera]);
  const double gate = kGateSigmas * sigma;
  std::mt19937_64 random(1);
  Directions best_directions{};
  double best_score = std::numeric_limits<double>::infinity();
  for (int draw = 0; draw < kDraws; ++draw) {
    for (std::size_t k = 0; k < kSubset; ++k)  // partial shuffle: no index twice
      std::swap(usable_[k], usable_[k + random() % (num_usable_ - k)]);
    Eigen::Vector3d bg = Eigen::Vector3d::Zero();
    Directions directions{};
    for (int s = 0; s < kSubsetSteps; ++s)
      step({usable_.data(), kSubset}, sigma, prior_sigma, directions, bg);
    const double cost = score(bg, directions, gate) + 0.5 * (bg / prior_sigma).squaredNorm();
    if (!(cost < best_score)) continue;
    best_score = cost;
    best = bg;
    best_directions = directions;
  }
  Directions directions = best_directions;
  for (int s = 0; s < kPolishSteps; ++s) {
    (void)score(best, directions, gate);
    for (std::size_t k = 0; k < num_usable_; ++k) {  // Geman-McClure, per track
      const double q = gate * gate / (gate * gate + error_[usable_[k]]);
      weight_[usable_[k]] = q * q;
    }
    step({usable_.data(), num_usable_}, sigma, prior_sigma, directions, best);
  }
  return best;
}

double median_motion_px(const Tracks& tracks, const ImuPath& path, const RigCalibration& rig,
                        bool rotate) noexcept {
  std::array<double, kMaxTracks> motion{};
  std::size_t n = 0;
  const double half_s = 0.5 * path[path.size() - 1].t_s;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const Sight& a = tracks.sights(i).front();
    const Sight& b = tracks.sights(i).back();
    if (path[b.frame].t_s - path[a.frame].t_s < half_s) continue;
    const CameraCalibration& camera = rig.cameras[tracks.camera(i)];
    Eigen::Vector3d there = a.ray();
    if (rotate) {
      const Eigen::Matrix3d R_bc = camera.T_body_cam.R();
      there = R_bc.transpose() * path[b.frame].R_0k.transpose() * path[a.frame].R_0k * R_bc * there;
    }
    if (!(there.z() > 0.1)) continue;
    const Eigen::Vector2d d = there.head<2>() / there.z() - b.ray().head<2>();
    motion[n++] = d.norm() * mean_focal_px(camera);
  }
  if (n == 0) return 0;
  const auto middle = motion.begin() + static_cast<std::ptrdiff_t>(n / 2);
  std::nth_element(motion.begin(), middle, motion.begin() + static_cast<std::ptrdiff_t>(n));
  return *middle;
}

}  // namespace pled::start
