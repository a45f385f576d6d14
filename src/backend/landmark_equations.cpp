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

/// Where refined calibration has its rows; -1: not refined.
struct CalibrationRows {
  int extrinsic;
  int time_shift;
};

/// What one sighting says of calibration, by itself and together with the landmark.
template <int N>
void add_calibration(PriorMatrix& H, PriorVector& b, const CalibrationRows& rows,
                     const Eigen::Matrix<double, 2, 6>& extrinsic,
                     const Eigen::Matrix<double, 2, 1>& time_shift,
                     const Eigen::Matrix<double, 2, N>& own, const Eigen::Vector2d& r, double w,
                     LandmarkBlocks<N>& out) noexcept {
  if (rows.extrinsic >= 0) {
    add_product<6, 6>(H, rows.extrinsic, rows.extrinsic, extrinsic, extrinsic, w);
    b.segment<6>(rows.extrinsic).noalias() += w * extrinsic.transpose() * r;
    out.W_extrinsic.noalias() += w * extrinsic.transpose() * own;
  }
  if (rows.time_shift >= 0) {
    add_product<1, 1>(H, rows.time_shift, rows.time_shift, time_shift, time_shift, w);
    b[rows.time_shift] += w * time_shift.dot(r);
    out.W_time_shift.noalias() += w * time_shift.transpose() * own;
  }
  if (rows.extrinsic >= 0 && rows.time_shift >= 0)
    add_product<6, 1>(H, rows.extrinsic, rows.time_shift, extrinsic, time_shift, w);
}

/// The same together with one pose.
void add_pose_calibration(PriorMatrix& H, int row, const CalibrationRows& rows,
                          const Eigen::Matrix<double, 2, 6>& pose,
                          const Eigen::Matrix<double, 2, 6>& extrinsic,
                          const Eigen::Matrix<double, 2, 1>& time_shift, double w) noexcept {
  if (rows.extrinsic >= 0) add_product<6, 6>(H, row, rows.extrinsic, pose, extrinsic, w);
  if (rows.time_shift >= 0) add_product<6, 1>(H, row, rows.time_shift, pose, time_shift, w);
}

}  // namespace

void NormalEquations::add_sights(const Landmark& landmark, const RigCalibration& rig,
                                 const FactorSettings& settings, const PointSights& sights,
                                 PointBlocks& out) noexcept {
  const CalibrationRows rows{extrinsic_row_, time_shift_row_};
  const auto& seen = landmark.observations;
  out.clear();
  const int a = row_of(seen[0].state);
  (void)out.block_of(seen[0].state);
  for (std::size_t k = 0; k < sights.count; ++k) {
    const PointJacobians& J = sights.J[k];
    const Eigen::Vector2d& r = sights.r[k];
    const double w = sight_weight(settings, sights.squares[k], landmark.reliability.w);
    const Eigen::Matrix<double, kPointDim, 2> Jw = w * J.point.transpose();
    out.h.noalias() += Jw * J.point;
    out.g.noalias() += Jw * r;
    Eigen::Matrix<double, 2, 6> extrinsic = Eigen::Matrix<double, 2, 6>::Zero();
    if (rows.extrinsic >= 0 && seen[0].camera == rig.frame_camera) extrinsic += J.extrinsic_i;
    if (rows.extrinsic >= 0 && seen[k].camera == rig.frame_camera) extrinsic += J.extrinsic_j;
    add_calibration<kPointDim>(H_, b_, rows, extrinsic, J.time_shift, J.point, r, w, out);
    if (k == 0) continue;  // the anchor's own sighting depends on no pose
    const int c = row_of(seen[k].state);
    add_product<6, 6>(H_, a, a, J.pose_i, J.pose_i, w);
    add_product<6, 6>(H_, a, c, J.pose_i, J.pose_j, w);
    add_product<6, 6>(H_, c, c, J.pose_j, J.pose_j, w);
    add_pose_calibration(H_, a, rows, J.pose_i, extrinsic, J.time_shift, w);
    add_pose_calibration(H_, c, rows, J.pose_j, extrinsic, J.time_shift, w);
    b_.segment<6>(a).noalias() += w * J.pose_i.transpose() * r;
    b_.segment<6>(c).noalias() += w * J.pose_j.transpose() * r;
    out.W[0].noalias() += J.pose_i.transpose() * Jw.transpose();
    out.W[out.block_of(seen[k].state)].noalias() += J.pose_j.transpose() * Jw.transpose();
  }
}

void NormalEquations::add_sights(const LineLandmark& line, const RigCalibration& rig,
                                 const FactorSettings& settings, const LineSights& sights,
                                 LineBlocks& out) noexcept {
  const CalibrationRows rows{extrinsic_row_, time_shift_row_};
  const auto& seen = line.observations;
  out.clear();
  for (std::size_t k = 0; k < sights.count; ++k) {
    const LineJacobians& J = sights.J[k];
    const Eigen::Vector2d& r = sights.r[k];
    const double w = sight_weight(settings, sights.squares[k], line.reliability.w);
    const Eigen::Matrix<double, kLineDim, 2> Jw = w * J.line.transpose();
    out.h.noalias() += Jw * J.line;
    out.g.noalias() += Jw * r;
    Eigen::Matrix<double, 2, 6> extrinsic = Eigen::Matrix<double, 2, 6>::Zero();
    if (rows.extrinsic >= 0 && seen[k].camera == rig.frame_camera) extrinsic = J.extrinsic;
    add_calibration<kLineDim>(H_, b_, rows, extrinsic, J.time_shift, J.line, r, w, out);
    const int c = row_of(seen[k].state);
    add_product<6, 6>(H_, c, c, J.pose, J.pose, w);
    add_pose_calibration(H_, c, rows, J.pose, extrinsic, J.time_shift, w);
    b_.segment<6>(c).noalias() += w * J.pose.transpose() * r;
    out.W[out.block_of(seen[k].state)].noalias() += J.pose.transpose() * Jw.transpose();
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
