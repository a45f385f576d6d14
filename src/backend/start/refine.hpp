#pragma once

#include <array>

#include <Eigen/Core>

#include "pled_vins/backend/start.hpp"
#include "src/backend/start/imu_path.hpp"
#include "src/backend/start/tracks.hpp"

namespace pled::start {

/// What the whole motion follows from. Tangent order (12): v_0, gravity direction (2), gravity
/// magnitude, gyro bias, accelerometer bias.
struct MotionState {
  Eigen::Vector3d v_0 = Eigen::Vector3d::Zero();  ///< m/s, frame 0
  Eigen::Vector3d g_0 = Eigen::Vector3d::Zero();  ///< m/s^2, frame 0
  Eigen::Vector3d bg = Eigen::Vector3d::Zero();   ///< rad/s
  Eigen::Vector3d ba = Eigen::Vector3d::Zero();   ///< m/s^2
};
inline constexpr int kMotionSize = 12;
inline constexpr int kGravityMagnitude = 5;
using MotionVector = Eigen::Matrix<double, kMotionSize, 1>;
using MotionMatrix = Eigen::Matrix<double, kMotionSize, kMotionSize>;

[[nodiscard]] MotionState box_plus(const MotionState& x, const MotionVector& d) noexcept;

/// A point in the camera of its first sight: direction (x, y, 1) / rho.
struct StartPoint {
  Eigen::Vector3d xy_rho = Eigen::Vector3d::Zero();
};

/// A camera at one frame of a motion: place and derivatives, all in frame 0.
struct CameraView {
  Eigen::Matrix3d R_0c = Eigen::Matrix3d::Identity();
  Eigen::Vector3d c_0 = Eigen::Vector3d::Zero();  ///< centre
  Eigen::Matrix<double, 3, kMotionSize> d_c = Eigen::Matrix<double, 3, kMotionSize>::Zero();
  Eigen::Matrix3d d_turn_d_bg = Eigen::Matrix3d::Zero();  ///< R_0c m turns by this x (R_0c m)
};
[[nodiscard]] CameraView view(const MotionState& x, const PathPoint& at,
                              const Pose& T_body_cam) noexcept;

/// One reprojection: residual (z = 1 plane, 2) and derivatives by the point (2 x 3).
struct Reprojection {
  Eigen::Vector2d r;
  Eigen::Matrix<double, 2, 3> d_point;
  Eigen::Matrix<double, 2, 3> d_y;  ///< by the ray in frame 0
  Eigen::Vector3d u, y;             ///< the ray at the anchor and here, frame 0
};
/// False when the point is behind the camera.
[[nodiscard]] bool reproject(const CameraView& anchor, const CameraView& at,
                             const StartPoint& point, const Eigen::Vector2d& seen,
                             Reprojection& out) noexcept;
/// Derivative of a reprojection by the motion.
[[nodiscard]] Eigen::Matrix<double, 2, kMotionSize> d_motion(const CameraView& anchor,
                                                             const CameraView& at,
                                                             const StartPoint& point,
                                                             const Reprojection& at_point) noexcept;

/// Verdict on a refined motion.
struct MotionQuality {
  double inlier_share = 0;  ///< of tracks
  int inlier_cells = 0;     ///< of a 3 x 3 grid of the image
  std::size_t inliers = 0;
  double error_sigmas = 0;        ///< rms of the inliers, in sigmas of one axis
  double scale_sigma = 0;         ///< relative, of the travelled path, by the errors seen
  double gravity_error_mps2 = 0;  ///< how far |g| would move if it were free
  double gravity_sigma_mps2 = 0;  ///< and how well it would be known
};

/// Robust least squares over the motion with all points eliminated. Trajectories follow from the
/// motion by the IMU exactly (its noise over a second is negligible here).
class MotionRefiner {
 public:
  /// Improves `x` and leaves `path` integrated at its biases. False when it broke down or did not
  /// converge.
  [[nodiscard]] bool refine(const StartFrames& frames, const ImuHistory& imu,
                            const RigCalibration& rig, const BackendConfig& config,
                            const StartBelief& belief, const Tracks& tracks, ImuPath& path,
                            MotionState& x) noexcept;

  /// After refine().
  [[nodiscard]] MotionQuality judge(const RigCalibration& rig, const BackendConfig& config,
                                    const StartBelief& belief, const Tracks& tracks,
                                    const ImuPath& path, const MotionState& x) noexcept;
  [[nodiscard]] bool inlier(std::size_t track) const noexcept { return inlier_[track]; }

 private:
  void look(const RigCalibration& rig, const ImuPath& path, const MotionState& x) noexcept;
  [[nodiscard]] const CameraView& view_of(const Tracks& tracks, std::size_t track,
                                          const Sight& sight) const noexcept {
    return views_[tracks.camera(track) * kMaxFrames + sight.frame];
  }
  /// Depth of each point along its ray at the anchor, linearly.
  void triangulate(const Tracks& tracks) noexcept;
  /// Best point for each track seen from the views; its mean squared error into error_. Total
  /// robust cost.
  double fit_points(const Tracks& tracks, double sigma, double scale) noexcept;
  /// Error, sigmas, that two fifths of the first `num` tracks stay below.
  [[nodiscard]] double spread(std::size_t num) noexcept;
  /// What the inliers' errors make of a sigma that was worked out for white errors of one sigma:
  /// the part that lasts from sight to sight weighs more than the part that changes.
  [[nodiscard]] double spread_of_inliers(const Tracks& tracks, double sigma,
                                         double error_sigmas) const noexcept;
  /// Adds the normal equations of all tracks, points eliminated.
  void build(const Tracks& tracks, double sigma, double scale, MotionMatrix& H,
             MotionVector& b) const noexcept;

  std::array<CameraView, limits::kMaxCameras * kMaxFrames> views_{};
  std::array<StartPoint, kMaxTracks> points_{};
  std::array<StartPoint, kMaxTracks> saved_{};
  std::array<double, kMaxTracks> error_{};  ///< mean squared error per degree of freedom, sigmas^2
  std::array<double, kMaxTracks> sorted_{};
  std::array<bool, kMaxTracks> inlier_{};
};

}  // namespace pled::start
