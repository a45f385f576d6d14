#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "pled_vins/backend/line_residual.hpp"
#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/imu/preintegration.hpp"

namespace pled {

inline constexpr int kPoseDim = 6;    ///< p, theta
inline constexpr int kMotionDim = 9;  ///< v, bg, ba
inline constexpr int kStateDim = 15;  ///< p, theta, v, bg, ba
inline constexpr int kExtrinsicDim = 6;
inline constexpr int kMaxWindowDim =
    static_cast<int>(limits::kWindowStates) * kStateDim + kExtrinsicDim + 1;

/// Points known to the window; at most limits::kMaxPoints of them are solved.
inline constexpr std::size_t kMaxLandmarks = 480;
/// Lines known to the window; at most limits::kMaxLines of them are solved.
inline constexpr std::size_t kMaxLineLandmarks = 192;

using PriorMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxWindowDim, kMaxWindowDim>;
using PriorVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxWindowDim, 1>;

/// One sighting of a point from a state of the window.
struct Observation {
  std::uint8_t state = 0;           ///< index into the window
  std::uint8_t camera = 0;          ///< index into the rig
  std::array<double, 2> xy{};       ///< bearing on the plane z = 1
  std::array<double, 2> rate_ps{};  ///< its rate, 1/s
  FeatureKind kind = FeatureKind::kImagePoint;
};

/// How far a point or line is believed.
struct Reliability {
  double w = 1.0;                    ///< multiplies its residuals; constant while marginalising
  double previous = 1.0;             ///< w~ of the loss: w after the last frame
  double w_geometric = kNoEvidence;  ///< what this frame's geometry alone would make of w
  double temporal = kNoEvidence;     ///< what time tells, of the newest sighting
  double alpha_line = kNoEvidence;   ///< of the paper's fusion, lines only
  std::uint32_t rounds = 0;          ///< frames in which it was weighed
  std::uint32_t at_rest = 0;         ///< frames on end in which time told that it rests
};

/// A point in inverse depth, in the camera of its first observation (the anchor): the bearing on
/// the plane z = 1 and the inverse depth along it. The bearing is estimated too, since the anchor's
/// sighting is as noisy as any other.
struct Landmark {
  FeatureId id = 0;
  FixedVector<Observation, limits::kWindowStates> observations;  ///< by state, ascending
  std::array<double, 3> bearing_depth{};  ///< x, y on z = 1; inverse depth, 1/m
  double prior_inverse_depth_pm = 0.0;
  bool weak_depth = false;  ///< too little parallax: held by the scene's depth
  bool has_depth = false;
  bool rejected = false;  ///< found to move or to be wrong; ignored until it ends
  bool in_solver = false;
  double weight = kNoEvidence;        ///< mean Cauchy weight over its observations
  double depth_information_m2 = 0.0;  ///< of the inverse depth, by its sightings when last judged
  std::uint8_t strikes = 0;           ///< frames on end in which it came where it cannot have
  std::uint16_t age = 0;              ///< frames since its first
  Reliability reliability;

  [[nodiscard]] double inverse_depth_pm() const noexcept { return bearing_depth[2]; }
  [[nodiscard]] Eigen::Vector3d ray() const noexcept {
    return {bearing_depth[0], bearing_depth[1], 1.0};
  }
};

/// A line in the axes of the world, about an origin of its own: the camera that saw it first.
/// Unlike a point it hangs on no state.
struct LineLandmark {
  FeatureId id = 0;
  FixedVector<LineObservation, limits::kWindowStates> observations;  ///< by state, ascending
  std::array<double, 4> U_xyzw{0, 0, 0, 1};                          ///< see OrthonormalLine
  double phi_rad = 0.0;
  std::array<double, 3> origin_world_m{};
  bool has_line = false;  ///< triangulated
  bool rejected = false;
  bool in_solver = false;
  double weight = kNoEvidence;  ///< mean Cauchy weight over its observations
  std::uint8_t strikes = 0;     ///< as of a point
  std::uint16_t age = 0;        ///< frames since its first
  Reliability reliability;

  [[nodiscard]] OrthonormalLine line() const noexcept {
    return {Eigen::Quaterniond(U_xyzw[3], U_xyzw[0], U_xyzw[1], U_xyzw[2]), phi_rad};
  }
  void set_line(const OrthonormalLine& to) noexcept {
    U_xyzw = {to.U.x(), to.U.y(), to.U.z(), to.U.w()};
    phi_rad = to.phi_rad;
  }
  [[nodiscard]] Eigen::Vector3d origin_world() const noexcept {
    return {origin_world_m[0], origin_world_m[1], origin_world_m[2]};
  }
};

/// A Gaussian belief about one state: |S (x (-) mean)|^2.
struct StatePrior {
  NavState mean;
  Matrix15d sqrt_information = Matrix15d::Zero();
};

/// One instant of the window, and the inertial data that lead to it.
struct WindowState {
  NavState x;      ///< estimate
  NavState first;  ///< first estimate: where Jacobians are taken once the prior knows it
  bool has_first = false;
  bool keyframe = false;
  bool still = false;  ///< found standing: v = 0
  int still_as = -1;   ///< state at the same place, or -1
  /// Of the information of one independent finding that the rig stands: findings of frames that
  /// follow each other closely are wrong together.
  double still_share = 1.0;
  bool has_imu = false;  ///< imu and preintegration lead from the state before
  FixedVector<ImuSample, limits::kMaxImuPerInterval> imu;
  Preintegration preintegration;
  std::optional<StatePrior> prior;

  [[nodiscard]] const NavState& linearisation(bool first_estimates) const noexcept {
    return first_estimates && has_first ? first : x;
  }
};

/// What is left of states and points that were marginalised: |r0 + J dx|^2 with dx the
/// change of the states it touches from their first estimates.
struct MarginalPrior {
  bool valid = false;
  PriorMatrix J;
  PriorVector r0;
  std::array<int, limits::kWindowStates> pose_column{};    ///< -1: untouched
  std::array<int, limits::kWindowStates> motion_column{};  ///< -1: untouched
  int extrinsic_column = -1;
  int time_shift_column = -1;

  void clear() noexcept {
    valid = false;
    pose_column.fill(-1);
    motion_column.fill(-1);
    extrinsic_column = time_shift_column = -1;
  }
};

/// Calibration that may be refined online, with its belief and first estimate.
struct RigState {
  Pose T_body_cam;  ///< of the refined camera
  Pose first_T_body_cam;
  Pose mean_T_body_cam;       ///< as calibrated
  double time_shift_s = 0.0;  ///< on top of the calibrated one
  double first_time_shift_s = 0.0;
};

/// The sliding window: up to ten keyframes and the newest state, the points and lines seen
/// from them, and the prior. Plain data in fixed memory.
class SlidingWindow {
 public:
  SlidingWindow() noexcept { clear(); }
  void clear() noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return order_.size(); }
  [[nodiscard]] bool full() const noexcept { return order_.full(); }
  [[nodiscard]] WindowState& state(std::size_t i) noexcept { return slots_[order_[i]]; }
  [[nodiscard]] const WindowState& state(std::size_t i) const noexcept { return slots_[order_[i]]; }
  [[nodiscard]] WindowState& newest() noexcept { return state(size() - 1); }
  [[nodiscard]] const WindowState& newest() const noexcept { return state(size() - 1); }

  /// Adds an empty state at the end; null when full.
  [[nodiscard]] WindowState* push_state() noexcept;
  /// Takes state i out: its observations go (anchors move on, depths with them), later
  /// indices shift down. The prior must not touch it; the caller sees to inertial data.
  void erase_state(std::size_t i, const RigCalibration& rig) noexcept;

  /// Removes the first `count` observations of a point and carries its depth to the next.
  /// The point may end without observations.
  void drop_observations(Landmark& landmark, std::size_t count, const RigCalibration& rig) noexcept;
  /// Forgets points for which `gone` is true.
  template <typename Predicate>
  void erase_landmarks(const Predicate& gone) noexcept {
    erase_where(landmarks, gone);
  }
  /// Forgets lines for which `gone` is true.
  template <typename Predicate>
  void erase_lines(const Predicate& gone) noexcept {
    erase_where(lines, gone);
  }
  [[nodiscard]] Landmark* find(FeatureId id) noexcept;
  [[nodiscard]] LineLandmark* find_line(FeatureId id) noexcept;

  /// Pose of a camera on the body as now estimated.
  [[nodiscard]] Pose T_body_cam(std::uint8_t camera, const RigCalibration& rig) const noexcept {
    return camera == rig.frame_camera ? rig_state.T_body_cam : rig.cameras[camera].T_body_cam;
  }

  FixedVector<Landmark, kMaxLandmarks> landmarks;
  FixedVector<LineLandmark, kMaxLineLandmarks> lines;
  MarginalPrior prior;
  RigState rig_state;

 private:
  template <typename Items, typename Predicate>
  static void erase_where(Items& items, const Predicate& gone) noexcept {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (gone(items[i])) continue;
      if (kept != i) items[kept] = items[i];
      ++kept;
    }
    while (items.size() > kept) items.pop_back();
  }

  std::array<WindowState, limits::kWindowStates> slots_{};
  FixedVector<std::uint8_t, limits::kWindowStates> order_;
};

}  // namespace pled
