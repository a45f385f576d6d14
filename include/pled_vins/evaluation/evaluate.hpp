#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pled_vins/evaluation/trajectory.hpp"

namespace pled {

/// When the camera delivered frames, and how often.
struct FrameSpan {
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
  std::int64_t period_ns = 0;  ///< median
};

/// Span and median period of frame stamps; nullopt when there are fewer than two.
[[nodiscard]] std::optional<FrameSpan> frame_span(std::span<const std::int64_t> stamps_ns);

/// A pose of the estimate, laid on the truth, and how far it is from it.
struct PositionError {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d estimate_m;  ///< after the alignment, in the truth's frame
  Eigen::Vector3d truth_m;
  double error_m = 0.0;
};

/// Figures of merit of a trajectory. A figure that cannot be told is absent.
struct Evaluation {
  /// Root mean square distance to the truth after the rigid alignment that
  /// minimises it (rotation and translation, no scale).
  std::optional<double> ate_rmse_m;
  /// 100 x mean distance to the truth, so aligned, by the length of the truth's path
  /// between the first and the last matched pose.
  std::optional<double> mpe_percent;
  /// Relative error over 1 s, root mean square: of the pairs (i, j) of matched poses
  /// where j is the first with t_j >= t_i + 1 s - h and |t_j - t_i - 1 s| <= h, h half
  /// the median period of the trajectory. Error: (Q_i^-1 Q_j)^-1 (P_i^-1 P_j).
  std::optional<double> rpe_trans_m;
  std::optional<double> rpe_rot_deg;
  /// Time between consecutive poses no more than two frame periods apart, inside the
  /// overlap of frames and truth, by the length of that overlap.
  std::optional<double> coverage;

  std::size_t poses = 0;          ///< in the trajectory
  std::size_t matched = 0;        ///< compared with the truth
  std::size_t outside_truth = 0;  ///< dropped: before its start or after its end
  std::size_t in_truth_gap = 0;   ///< dropped: between truth poses more than 0.1 s apart
  std::size_t rpe_pairs = 0;
  std::optional<double> path_m;  ///< length of the truth's path over the evaluated span
  std::optional<double> span_s;  ///< first to last matched pose
  Pose T_truth_estimate;         ///< the alignment: truth = T * estimate
  std::vector<PositionError> position_errors;  ///< one a matched pose: the ATE over time
  std::vector<std::string> notes;              ///< why a figure is absent or what it rests on
};

/// Compares a trajectory with the truth, interpolated linearly and by slerp at its
/// stamps. Without `frames`, coverage is told over the overlap of trajectory and
/// truth, with the trajectory's own median period, and a note says so. Both inputs
/// strictly increasing in time.
[[nodiscard]] Evaluation evaluate(std::span<const StampedPose> estimate,
                                  std::span<const StampedPose> truth,
                                  const std::optional<FrameSpan>& frames);

}  // namespace pled
