#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "pled_vins/backend/bootstrap.hpp"
#include "pled_vins/backend/config.hpp"
#include "pled_vins/backend/feature_noise.hpp"
#include "pled_vins/backend/landmark_book.hpp"
#include "pled_vins/backend/line_book.hpp"
#include "pled_vins/backend/marginalisation.hpp"
#include "pled_vins/backend/start.hpp"
#include "pled_vins/backend/still_detector.hpp"
#include "pled_vins/backend/window_solver.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/imu/imu_history.hpp"

namespace pled {

/// What the back end says after each frame.
struct BackendOutput {
  bool has_pose = false;  ///< false before the start and while lost
  PoseEstimate pose;
  /// One per point of the measurement, in its order, whatever became of it.
  FixedVector<FeatureWeight, limits::kMaxPoints> weights;
  FixedVector<FeatureWeight, limits::kMaxLines> line_weights;  ///< the same of lines
  StartRefusal refusal = StartRefusal::kNone;                  ///< while !has_pose: why not
  double refusal_detail = 0.0;
  bool keyframe = false;
  int iterations = 0;
  std::uint16_t points_in_solver = 0;
  std::uint16_t lines_in_solver = 0;
  double mean_reprojection_px = 0.0;
};

/// What went wrong so far, counted.
struct BackendFaults {
  std::uint64_t imu_gaps = 0;        ///< holes in the inertial data that were bridged
  std::uint64_t divergences = 0;     ///< estimates thrown away
  std::uint64_t priors_lost = 0;     ///< marginalisations that were not finite
  std::uint64_t frames_refused = 0;  ///< stamps not after the last frame's
};

/// The sliding-window estimator: from points and inertial data to poses.
///
/// Several MB, all inside: keep it in static or heap storage. Allocates nothing itself; the solver
/// may. One thread.
class Backend {
 public:
  /// `rig` is copied; `solver` must outlive the back end.
  Backend(const BackendConfig& config, const RigCalibration& rig, WindowSolver& solver) noexcept;
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;
  ~Backend() = default;

  /// Takes one frame. `imu` must reach to the frame's time (at most its gap threshold short).
  void process(const FrameMeasurement& frame, const ImuHistory& imu, BackendOutput& out) noexcept;

  /// Skips the start: the next frame's state is believed to be `mean`, with the standard
  /// deviations `sigma` of its tangent. mean.t must be the time of that frame.
  void start_from(const NavState& mean, const Vector15d& sigma) noexcept;

  /// Before the first start: forgets the frames collected for it, because their times were wrong.
  void forget_frames() noexcept;
  /// Forgets everything but place, heading and biases, and the times of what was seen; the next
  /// frames start anew.
  void restart() noexcept;

  /// Covariance of the newest pose (p, theta), from the normal equations at the estimate;
  /// nullopt when not tracking or singular. Not for the data path: some milliseconds.
  [[nodiscard]] std::optional<Matrix6d> newest_pose_covariance() noexcept;

  [[nodiscard]] bool tracking() const noexcept { return tracking_; }
  [[nodiscard]] const BackendFaults& faults() const noexcept { return faults_; }
  [[nodiscard]] const SlidingWindow& window() const noexcept { return window_; }

  /// Experiments and tests: how the window forgets.
  void set_rules(LivePointRule rule, bool first_estimates) noexcept;

 private:
  enum class Verdict : std::uint8_t { kGood, kWeak, kDiverged };
  static constexpr Duration kSettling = Duration::from_ms(2000);

  void begin(const FrameMeasurement& frame, const ImuHistory& imu, BackendOutput& out) noexcept;
  void align_to_handover() noexcept;
  bool track(const FrameMeasurement& frame, const ImuHistory& imu, BackendOutput& out) noexcept;
  bool append_state(const FrameMeasurement& frame, const ImuHistory& imu) noexcept;
  void bridge_gap(const NavState& last, WindowState& state) noexcept;
  [[nodiscard]] int solver_steps(Duration since_last) noexcept;
  void note_standstill(const FrameMeasurement& frame) noexcept;
  void repropagate() noexcept;
  [[nodiscard]] Verdict check(const NavState& predicted, const SolveSummary& summary,
                              const BackendOutput& out) noexcept;
  [[nodiscard]] bool is_keyframe(const FrameMeasurement& frame) const noexcept;
  void slide() noexcept;
  void drop_second_newest() noexcept;
  void lose(const NavState& last, Timestamp t) noexcept;
  void coast(const FrameMeasurement& frame, const ImuHistory& imu, BackendOutput& out) noexcept;
  void write_pose(const NavState& x, const FrameMeasurement& frame, EstimatorStatus status,
                  BackendOutput& out) const noexcept;
  void offer(const FrameMeasurement& frame) noexcept;
  void begin_weights(const FrameMeasurement& frame, BackendOutput& out) const noexcept;
  void write_weights(BackendOutput& out) noexcept;
  void end_weights(BackendOutput& out) const noexcept;

  BackendConfig config_;
  BackendConfig start_config_;  ///< with the noise assumed until the start
  RigCalibration rig_;
  ImuNoise noise_;
  FactorSettings settings_;
  FeatureNoise feature_noise_;
  WindowSolver& solver_;
  LandmarkBook book_;
  LineBook line_book_;
  Bootstrap bootstrap_;
  StillDetector still_;
  Marginaliser marginaliser_;
  SlidingWindow window_;
  NormalEquations equations_;

  FrameMeasurement offered_;
  bool tracking_ = false;
  bool bridging_ = false;  ///< the last frame lay in or behind a hole of the inertial data
  std::optional<StatePrior> given_start_;
  StartBelief belief_;
  std::optional<NavState> handover_;  ///< last good state, carried on while not tracking
  Timestamp lost_at_;
  Timestamp last_frame_t_;
  Timestamp degraded_until_;
  Duration settling_left_;  ///< of motion since the start or a hole
  std::optional<Timestamp> weak_since_;
  std::uint32_t reset_counter_ = 0;
  FixedVector<ImuSample, limits::kMaxImuPerInterval> coast_imu_;
  BackendFaults faults_;
};

}  // namespace pled
