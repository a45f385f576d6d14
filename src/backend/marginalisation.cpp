#include "pled_vins/backend/marginalisation.hpp"

#include <array>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace pled {
namespace {

/// Share of the largest eigenvalue, after scaling to a unit diagonal, below which a
/// direction counts as unknown.
constexpr double kRankThreshold = 1e-12;

struct Block {
  int row;
  int size;
  int* column;  ///< where the prior keeps this block's place
};
using Blocks = FixedVector<Block, 2 * limits::kWindowStates + 2>;

bool touched(const PriorMatrix& H, int row, int size) {
  return (H.diagonal().segment(row, size).array() > 0).any();
}

}  // namespace

void Marginaliser::add_points(SlidingWindow& window, const RigCalibration& rig,
                              const FactorSettings& settings) noexcept {
  const std::size_t last = window.size() - 1;
  for (Landmark& landmark : window.landmarks) {
    auto& seen = landmark.observations;
    if (seen.empty() || seen[0].state != 0) continue;
    if (!landmark.in_solver || landmark.rejected) {
      window.drop_observations(landmark, 1, rig);
      continue;
    }
    const bool live = seen.back().state == last;
    std::size_t count = seen.size();
    if (live && rule_ == LivePointRule::kDrop) count = 0;
    if (live && rule_ == LivePointRule::kSplit) count = (count + 1) / 2;
    if (count >= 2) equations_.add_point(window, rig, settings, landmark, count);
    window.drop_observations(landmark, count >= 2 ? count : 1, rig);
    if (seen.empty()) landmark.has_depth = false;
  }
}

/// A line hangs on no state, so one that goes on needs nothing carried over; its sightings are
/// split as a point's are.
void Marginaliser::add_lines(SlidingWindow& window, const RigCalibration& rig,
                             const FactorSettings& settings) noexcept {
  const std::size_t last = window.size() - 1;
  for (LineLandmark& line : window.lines) {
    auto& seen = line.observations;
    if (seen.empty() || seen[0].state != 0) continue;
    std::size_t count = seen.size();
    const bool live = seen.back().state == last;
    if (live && rule_ == LivePointRule::kDrop) count = 0;
    if (live && rule_ == LivePointRule::kSplit) count = (count + 1) / 2;
    const bool counts = line.in_solver && !line.rejected && count >= 2;
    if (counts) equations_.add_line(window, rig, settings, line, count);
    for (std::size_t k = counts ? count : 1; k > 0; --k) seen.erase(0);
    if (seen.size() < 2) line.has_line = false;
  }
}

bool Marginaliser::marginalise(SlidingWindow& window, const RigCalibration& rig,
                               const FactorSettings& settings, std::size_t k) noexcept {
  equations_.reset(window, settings);
  equations_.add_marginal_prior(window);
  equations_.add_imu(window, k, settings);
  equations_.add_state(window, k, settings);
  equations_.add_same_place(window, k, settings);
  if (k + 1 < window.size()) equations_.add_imu(window, k + 1, settings);
  for (std::size_t i = 0; i < window.size(); ++i) {
    if (window.state(i).still_as != static_cast<int>(k)) continue;
    equations_.add_same_place(window, i, settings);
    window.state(i).still_as = -1;
  }
  if (k == 0) {
    add_points(window, rig, settings);
    add_lines(window, rig, settings);
  }
  equations_.complete();
  if (k + 1 < window.size()) {  // that interval now speaks through the prior
    window.state(k + 1).has_imu = false;
    window.state(k + 1).imu.clear();
  }
  const bool ok = eliminate(window, k);
  if (!ok) window.prior.clear();
  window.erase_state(k, rig);
  return ok;
}

void Marginaliser::schur(std::size_t k) noexcept {
  PriorMatrix& H = equations_.H();
  PriorVector& b = equations_.b();
  // Directions of state k that nobody knows are left out.
  const int row = static_cast<int>(k) * kStateDim;
  const Matrix15d H_kk = H.block<15, 15>(row, row);
  const Vector15d scale = H_kk.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  const Matrix15d scaled = scale.asDiagonal() * H_kk * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix15d> eigen(scaled);
  Vector15d inverse = eigen.eigenvalues();
  const double floor = kRankThreshold * inverse.maxCoeff();
  for (int i = 0; i < 15; ++i) inverse[i] = inverse[i] > floor ? 1.0 / inverse[i] : 0.0;
  const Matrix15d V = scale.asDiagonal() * eigen.eigenvectors();
  const Matrix15d H_kk_inverse = V * inverse.asDiagonal() * V.transpose();
  const Eigen::Matrix<double, 15, Eigen::Dynamic, 0, 15, kMaxWindowDim> H_kr =
      H_kk_inverse * H.middleRows<15>(row);
  const Vector15d step = H_kk_inverse * b.segment<15>(row);
  b.noalias() -= H.middleCols<15>(row) * step;
  const Eigen::Matrix<double, Eigen::Dynamic, 15, 0, kMaxWindowDim, 15> H_rk =
      H.middleCols<15>(row);
  H.noalias() -= H_rk * H_kr;
}

bool Marginaliser::eliminate(SlidingWindow& window, std::size_t k) noexcept {
  const PriorMatrix& H = equations_.H();
  const PriorVector& b = equations_.b();
  if (!H.allFinite() || !b.allFinite()) return false;
  schur(k);
  MarginalPrior& prior = window.prior;
  prior.clear();
  Blocks blocks;
  for (std::size_t i = 0; i < window.size(); ++i) {
    if (i == k) continue;
    const int at = static_cast<int>(i) * kStateDim;
    bool any = false;
    if (touched(H, at, kPoseDim)) any |= blocks.push_back({at, kPoseDim, &prior.pose_column[i]});
    if (touched(H, at + kPoseDim, kMotionDim))
      any |= blocks.push_back({at + kPoseDim, kMotionDim, &prior.motion_column[i]});
    WindowState& state = window.state(i);
    if (any && !state.has_first) {
      state.first = state.x;
      state.has_first = true;
    }
  }
  if (equations_.extrinsic_row() >= 0 && touched(H, equations_.extrinsic_row(), kExtrinsicDim))
    (void)blocks.push_back({equations_.extrinsic_row(), kExtrinsicDim, &prior.extrinsic_column});
  if (equations_.time_shift_row() >= 0 && touched(H, equations_.time_shift_row(), 1))
    (void)blocks.push_back({equations_.time_shift_row(), 1, &prior.time_shift_column});
  int dim = 0;
  for (const Block& block : blocks) {
    *block.column = dim;
    dim += block.size;
  }
  if (dim == 0) return true;
  H_.resize(dim, dim);
  b_.resize(dim);
  for (const Block& p : blocks) {
    b_.segment(*p.column, p.size) = b.segment(p.row, p.size);
    for (const Block& q : blocks)
      H_.block(*p.column, *q.column, p.size, q.size) = H.block(p.row, q.row, p.size, q.size);
  }
  return factorise(window);
}

bool Marginaliser::factorise(SlidingWindow& window) noexcept {
  MarginalPrior& prior = window.prior;
  // H = D V L V^T D with D = sqrt(diag H): units of the states do not mix in the rank.
  const PriorVector D = H_.diagonal().cwiseMax(1e-12).cwiseSqrt();
  const PriorVector D_inverse = D.cwiseInverse();
  H_ = (0.5 * (H_ + H_.transpose())).eval();
  H_ = D_inverse.asDiagonal() * H_ * D_inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<PriorMatrix> eigen(H_);
  if (eigen.info() != Eigen::Success) return false;
  const PriorVector& values = eigen.eigenvalues();
  const double floor = kRankThreshold * values.maxCoeff();
  PriorVector root = PriorVector::Zero(values.size());
  PriorVector inverse_root = root;
  for (int i = 0; i < values.size(); ++i) {
    if (!(values[i] > floor)) continue;
    root[i] = std::sqrt(values[i]);
    inverse_root[i] = 1.0 / root[i];
  }
  prior.J.noalias() = root.asDiagonal() * eigen.eigenvectors().transpose() * D.asDiagonal();
  prior.r0.setZero(prior.J.rows());
  const PriorVector wanted =
      inverse_root.asDiagonal() * (eigen.eigenvectors().transpose() * D_inverse.cwiseProduct(b_));
  // b is the gradient at the estimate: J^T (r0 + J dx) = b.
  PriorVector J_dx;
  evaluate_marginal_prior(window, J_dx);
  prior.r0 = wanted - J_dx;
  prior.valid = prior.J.allFinite() && prior.r0.allFinite();
  return prior.valid;
}

}  // namespace pled
