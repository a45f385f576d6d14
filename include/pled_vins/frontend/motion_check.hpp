#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>

#include <Eigen/Core>

namespace pled {

/// One point seen at two times: bearings (x, y) on the plane z = 1 of each camera pose.
struct BearingPair {
  double from_x = 0, from_y = 0;
  double to_x = 0, to_y = 0;
};

/// How well one pair agrees with the motion of most.
struct MotionVerdict {
  bool inlier = true;
  double residual_px = 0.0;  ///< distance to where the motion allows the point to be
};

/// What the check found besides the verdicts.
struct MotionEstimate {
  double median_parallax_px = 0.0;  ///< image motion left after the rotation is removed
  bool translating = false;         ///< false: too little parallax, judged as pure rotation
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit translation p_to = R p_from + t
};

/// Separates points that move with the scene from those that do not, knowing the rotation from the
/// gyro: two points give the direction of translation, t = (a1 x b1) x (a2 x b2) with
/// a = R_to_from * from and b = to; the rest vote by their distance to the epipolar line.
/// With a median parallax below one pixel the camera is taken to be turning on the spot.
/// Draws are seeded, so the same calls give the same verdicts. Fixed memory.
class MotionCheck {
 public:
  MotionCheck(double focal_px, double gate_px) noexcept : focal_px_(focal_px), gate_px_(gate_px) {}

  void reset() noexcept { random_ = std::mt19937_64{kSeed}; }

  /// @param R_to_from   takes bearings of the earlier camera to the later one
  /// @param pairs       up to limits::kMaxPoints
  /// @param verdicts    as many as pairs; all inliers when fewer than 8 pairs are given
  MotionEstimate judge(const Eigen::Matrix3d& R_to_from, std::span<const BearingPair> pairs,
                       std::span<MotionVerdict> verdicts) noexcept;

 private:
  static constexpr std::uint64_t kSeed = 0x706c6564ULL;

  double focal_px_;
  double gate_px_;
  std::mt19937_64 random_{kSeed};
};

}  // namespace pled
