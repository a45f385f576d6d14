// What points and lines add to the equations of the states.

#include <algorithm>

#include <Eigen/LU>

#include "pled_vins/backend/feature_loss.hpp"
#include "pled_vins/backend/normal_equations.hpp"
#include "src/backend/row_of.hpp"

namespace pled {
namespace {

/// Information below which a depth counts as unknown, 1/(1/m)^2: a point at this
/// information says nothing but its bearing.
constexpr double kMinDepthInformation = 1e-6;
/// The same of each of a line's four numbers, 1/rad^2.
constexpr double kMinLineInformation = 1e-6;

/// J^T w J of two of the blocks that a sighting depends on.
template <int A, int B>
void add_product(PriorMatrix& H, int row, int column, const Eigen::Matrix<double, 2, A>& J_a,
                 const Eigen::Matrix<double, 2, B>& J_b, double w) noexcept {
  H.block<A, B>(row, column).noalias() += (w * J_a).transpose() * J_b;
}

/// The equations of the states, and where refined calibration has its rows; -1: not refined.
struct Equations {
  PriorMatrix& H;
  PriorVector& b;
  int extrinsic;
  int time_shift;
};

/// One sighting of a landmark with N numbers of its own.
template <int N>
struct Sight {
  const Eigen::Vector2d& r;
  double w;
  const Eigen::Matrix<double, 2, N>& own;
  const Eigen::Vector2d& time_shift;
  Eigen::Matrix<double, 2, 6> extrinsic = Eigen::Matrix<double, 2, 6>::Zero();
  Eigen::Matrix<double, N, 2> weighted = w * own.transpose();
};

/// What a sighting says of the landmark, of calibration, and of the two together.
template <int N>
void add_own(const Equations& to, const Sight<N>& s, LandmarkBlocks<N>& out) noexcept {
  out.h.noalias() += s.weighted * s.own;
  out.g.noalias() += s.weighted * s.r;
  if (to.extrinsic >= 0) {
    add_product<6, 6>(to.H, to.extrinsic, to.extrinsic, s.extrinsic, s.extrinsic, s.w);
    to.b.segment<6>(to.extrinsic).noalias() += s.w * s.extrinsic.transpose() * s.r;
    out.W_extrinsic.noalias() += s.w * s.extrinsic.transpose() * s.own;
  }
  if (to.time_shift >= 0) {
    add_product<1, 1>(to.H, to.time_shift, to.time_shift, s.time_shift, s.time_shift, s.w);
    to.b[to.time_shift] += s.w * s.time_shift.dot(s.r);
    out.W_time_shift.noalias() += s.w * s.time_shift.transpose() * s.own;
  }
  if (to.extrinsic >= 0 && to.time_shift >= 0)
    add_product<6, 1>(to.H, to.extrinsic, to.time_shift, s.extrinsic, s.time_shift, s.w);
}

/// What it says of one pose, and of that together with calibration and landmark.
template <int N>
void add_pose(const Equations& to, const Sight<N>& s, int row,
              const Eigen::Matrix<double, 2, 6>& pose,
              Eigen::Matrix<double, kPoseDim, N>& W) noexcept {
  add_product<6, 6>(to.H, row, row, pose, pose, s.w);
  if (to.extrinsic >= 0) add_product<6, 6>(to.H, row, to.extrinsic, pose, s.extrinsic, s.w);
  if (to.time_shift >= 0) add_product<6, 1>(to.H, row, to.time_shift, pose, s.time_shift, s.w);
  to.b.segment<6>(row).noalias() += s.w * pose.transpose() * s.r;
  W.noalias() += pose.transpose() * s.weighted.transpose();
}

}  // namespace

void NormalEquations::add_sights(const Landmark& landmark, const RigCalibration& rig,
                                 const FactorSettings& settings, const PointSights& sights,
                                 PointBlocks& out) noexcept {
  const Equations to{H_, b_, extrinsic_row_, time_shift_row_};
  const auto& seen = landmark.observations;
  out.clear();
  const int a = row_of(seen[0].state);
  (void)out.block_of(seen[0].state);
  for (std::size_t k = 0; k < sights.count; ++k) {
    const PointJacobians& J = sights.J[k];
    const double w = sight_weight(settings, sights.squares[k], landmark.reliability.w);
    Sight<kPointDim> sight{sights.r[k], w, J.point, J.time_shift};
    if (to.extrinsic >= 0 && seen[0].camera == rig.frame_camera) sight.extrinsic += J.extrinsic_i;
    if (to.extrinsic >= 0 && seen[k].camera == rig.frame_camera) sight.extrinsic += J.extrinsic_j;
    add_own(to, sight, out);
    if (k == 0) continue;  // the anchor's own sighting depends on no pose
    const int c = row_of(seen[k].state);
    add_pose(to, sight, a, J.pose_i, out.W[0]);
    add_pose(to, sight, c, J.pose_j, out.W[out.block_of(seen[k].state)]);
    add_product<6, 6>(H_, a, c, J.pose_i, J.pose_j, w);
  }
}

void NormalEquations::add_sights(const LineLandmark& line, const RigCalibration& rig,
                                 const FactorSettings& settings, const LineSights& sights,
                                 LineBlocks& out) noexcept {
  const Equations to{H_, b_, extrinsic_row_, time_shift_row_};
  const auto& seen = line.observations;
  out.clear();
  for (std::size_t k = 0; k < sights.count; ++k) {
    const LineJacobians& J = sights.J[k];
    const double w = sight_weight(settings, sights.squares[k], line.reliability.w);
    Sight<kLineDim> sight{sights.r[k], w, J.line, J.time_shift};
    if (to.extrinsic >= 0 && seen[k].camera == rig.frame_camera) sight.extrinsic = J.extrinsic;
    add_own(to, sight, out);
    add_pose(to, sight, row_of(seen[k].state), J.pose, out.W[out.block_of(seen[k].state)]);
  }
}

template <int N>
void NormalEquations::eliminate_from(const LandmarkBlocks<N>& blocks,
                                     const Eigen::Matrix<double, N, N>& h_inverse, PriorMatrix& H,
                                     PriorVector& b) const noexcept {
  const int e = extrinsic_row_, t = time_shift_row_;
  for (std::size_t i = 0; i < blocks.count; ++i) {
    const int row = row_of(blocks.states[i]);
    const Eigen::Matrix<double, kPoseDim, N> part = blocks.W[i] * h_inverse;
    b.segment<kPoseDim>(row).noalias() -= part * blocks.g;
    for (std::size_t k = i; k < blocks.count; ++k)
      H.block<kPoseDim, kPoseDim>(row, row_of(blocks.states[k])).noalias() -=
          part * blocks.W[k].transpose();
    if (e >= 0)
      H.block<kPoseDim, kExtrinsicDim>(row, e).noalias() -= part * blocks.W_extrinsic.transpose();
    if (t >= 0) H.block<kPoseDim, 1>(row, t).noalias() -= part * blocks.W_time_shift.transpose();
  }
  if (e >= 0) {
    const Eigen::Matrix<double, kExtrinsicDim, N> part = blocks.W_extrinsic * h_inverse;
    b.segment<kExtrinsicDim>(e).noalias() -= part * blocks.g;
    H.block<kExtrinsicDim, kExtrinsicDim>(e, e).noalias() -= part * blocks.W_extrinsic.transpose();
    if (t >= 0) H.block<kExtrinsicDim, 1>(e, t).noalias() -= part * blocks.W_time_shift.transpose();
  }
  if (t >= 0) {
    const Eigen::Matrix<double, 1, N> part = blocks.W_time_shift * h_inverse;
    b[t] -= part.dot(blocks.g);
    H(t, t) -= part.dot(blocks.W_time_shift);
  }
}

template void NormalEquations::eliminate_from(const PointBlocks&,
                                              const Eigen::Matrix<double, kPointDim, kPointDim>&,
                                              PriorMatrix&, PriorVector&) const noexcept;
template void NormalEquations::eliminate_from(const LineBlocks&,
                                              const Eigen::Matrix<double, kLineDim, kLineDim>&,
                                              PriorMatrix&, PriorVector&) const noexcept;

void NormalEquations::add_point(const SlidingWindow& window, const RigCalibration& rig,
                                const FactorSettings& settings, const Landmark& landmark,
                                std::size_t count) noexcept {
  if (std::min(count, landmark.observations.size()) < 2) return;
  evaluate_sights(window, rig, settings, landmark, count, point_sights_);
  add_sights(landmark, rig, settings, point_sights_, point_blocks_);
  point_blocks_.h(2, 2) += kMinDepthInformation;
  const Eigen::Matrix3d h_inverse = point_blocks_.h.inverse();
  eliminate(point_blocks_, h_inverse);
}

void NormalEquations::add_line(const SlidingWindow& window, const RigCalibration& rig,
                               const FactorSettings& settings, const LineLandmark& line,
                               std::size_t count) noexcept {
  if (std::min(count, line.observations.size()) < 2) return;
  evaluate_sights(window, rig, settings, line, count, line_sights_);
  add_sights(line, rig, settings, line_sights_, line_blocks_);
  line_blocks_.h.diagonal().array() += kMinLineInformation;
  const Eigen::Matrix4d h_inverse = line_blocks_.h.inverse();
  eliminate(line_blocks_, h_inverse);
}

void NormalEquations::complete() noexcept {
  for (Eigen::Index column = 0; column < H_.cols(); ++column)
    for (Eigen::Index row = column + 1; row < H_.rows(); ++row) H_(row, column) = H_(column, row);
}

}  // namespace pled
