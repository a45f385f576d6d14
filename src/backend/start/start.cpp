#include "pled_vins/backend/start.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "pled_vins/geometry/so3.hpp"
#include "src/backend/start/gyro_bias.hpp"
#include "src/backend/start/imu_path.hpp"
#include "src/backend/start/linear.hpp"
#include "src/backend/start/refine.hpp"
#include "src/backend/start/still.hpp"
#include "src/backend/start/tracks.hpp"

namespace pled {
namespace start {
namespace {

constexpr std::size_t kMinFrames = 5;
constexpr std::size_t kMinSights = 4;
constexpr std::size_t kMinTracks = 15;
constexpr double kMinParallaxSigmas = 4.0;
constexpr double kMinInlierShare = 0.55;
constexpr int kMinInlierCells = 4;
constexpr double kGyroBiasSigmas = 3.0;   // a wrong motion pays with the gyro bias first
constexpr double kAccelBiasSigmas = 4.0;  // along gravity it is known well, so it must be believed
constexpr double kGravityExcessSigmas = 5.0;
constexpr double kGravitySlack_mps2 = 0.15;
constexpr double kGravitySigmas = 3.0;

/// Everything the search works with; about 200 KB.
class Search {
 public:
  Search(const StartFrames& frames, const ImuHistory& imu, const RigCalibration& rig,
         const BackendConfig& config, const StartBelief& belief) noexcept
      : frames_(frames), imu_(imu), rig_(rig), config_(config), belief_(belief) {}

  void run(StartGuess& guess) noexcept;

 private:
  [[nodiscard]] bool refuse(StartGuess& guess, StartRefusal why, double detail) const noexcept {
    guess.refusal = why;
    guess.detail = detail;
    return false;
  }
  [[nodiscard]] bool enough_data(StartGuess& guess) noexcept;
  [[nodiscard]] bool start_still(StartGuess& guess) noexcept;
  [[nodiscard]] bool start_moving(StartGuess& guess) noexcept;
  [[nodiscard]] bool accept(const MotionQuality& quality, const MotionState& x,
                            StartGuess& guess) const noexcept;
  void write_states(const MotionState& x, StartGuess& guess) const noexcept;

  const StartFrames& frames_;
  const ImuHistory& imu_;
  const RigCalibration& rig_;
  const BackendConfig& config_;
  const StartBelief& belief_;
  Tracks tracks_;
  ImuPath path_;
  GyroBiasSearch gyro_bias_;
  LinearSearch linear_;
  MotionRefiner refiner_;
};

/// World (z up, x forward: yaw 0) from the body in which gravity is g_b.
Eigen::Quaterniond upright(const Eigen::Vector3d& g_b) {
  const Eigen::Quaterniond q = so3::rotation_between(-g_b, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d x = q * Eigen::Vector3d::UnitX();
  const double yaw_rad = std::atan2(x.y(), x.x());
  const Eigen::Quaterniond unturn(Eigen::AngleAxisd(-yaw_rad, Eigen::Vector3d::UnitZ()));
  return (unturn * q).normalized();
}

void Search::write_states(const MotionState& x, StartGuess& guess) const noexcept {
  const Eigen::Quaterniond q_w0 = upright(x.g_0);
  guess.states.clear();
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    const PathPoint& p = path_[k];
    NavState state;
    state.t = frames_[k].t;
    state.p_wb = q_w0 * (p.t_s * x.v_0 + 0.5 * p.t_s * p.t_s * x.g_0 + p.alpha);
    state.v_wb = q_w0 * (x.v_0 + p.t_s * x.g_0 + p.beta);
    state.q_wb = (q_w0 * Eigen::Quaterniond(p.R_0k)).normalized();
    state.bg = x.bg;
    state.ba = x.ba;
    if (!guess.states.push_back(state)) break;
  }
}

bool Search::enough_data(StartGuess& guess) noexcept {
  if (frames_.size() < kMinFrames)
    return refuse(guess, StartRefusal::kTooFewFrames, static_cast<double>(frames_.size()));
  const double span_s = (frames_.back().t - frames_.front().t).seconds();
  if (!(span_s >= config_.init_min_span_s - 1e-6))
    return refuse(guess, StartRefusal::kTooShort, span_s);
  const StartRefusal imu = path_.integrate(frames_, imu_, belief_.bg, belief_.ba);
  if (imu != StartRefusal::kNone) return refuse(guess, imu, span_s);
  tracks_.build(frames_, kMinSights);
  if (tracks_.size() < kMinTracks)
    return refuse(guess, StartRefusal::kTooFewTracks, static_cast<double>(tracks_.size()));
  return true;
}

bool Search::start_still(StartGuess& guess) noexcept {
  // The plain path is needed again when this is no standing start.
  const Eigen::Vector3d mean_gyro = path_.mean_gyro();
  const Eigen::Vector3d mean_accel = path_.mean_accel();
  const Stillness s = judge_stillness(tracks_, frames_, imu_, rig_, config_, path_);
  if (!s.image_still || !s.imu_still) {
    const StartRefusal imu = path_.integrate(frames_, imu_, belief_.bg, belief_.ba);
    if (imu != StartRefusal::kNone) return refuse(guess, imu, 0);
    return refuse(guess, StartRefusal::kTooLittleParallax, s.image_motion_px);
  }
  // The part of the bias along gravity shows at once as a wrong magnitude. The parts across cannot
  // be told from a tilt: they stay as believed.
  const Eigen::Vector3d force = mean_accel - belief_.ba;
  const double excess = force.norm() - config_.gravity_mps2;
  if (!(std::abs(excess) < kGravityExcessSigmas * std::max(0.1, config_.accel_bias_sigma_mps2)))
    return refuse(guess, StartRefusal::kGravity, mean_accel.norm());
  const Eigen::Vector3d up_b = force.normalized();
  const Eigen::Quaterniond q_wb = upright(-up_b);
  guess.states.clear();
  for (const FrameMeasurement& frame : frames_) {
    NavState state;
    state.t = frame.t;
    state.q_wb = q_wb;
    state.bg = mean_gyro;
    state.ba = belief_.ba + excess * up_b;
    if (!guess.states.push_back(state)) break;
  }
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    if (!guess.inliers.push_back(tracks_.id(i))) break;
  guess.stationary = true;
  guess.detail = s.image_motion_px;
  guess.refusal = StartRefusal::kNone;
  return true;
}

bool Search::accept(const MotionQuality& q, const MotionState& x,
                    StartGuess& guess) const noexcept {
  if (!(q.inlier_share >= kMinInlierShare) || q.inliers < kMinTracks)
    return refuse(guess, StartRefusal::kOutliers, q.inlier_share);
  if (q.inlier_cells < kMinInlierCells)
    return refuse(guess, StartRefusal::kOutliers, q.inlier_share);
  const double bg_change = (x.bg - belief_.bg).norm();
  if (!(bg_change < kGyroBiasSigmas * belief_.bg_sigma_radps))
    return refuse(guess, StartRefusal::kBias, bg_change);
  const double ba_change = (x.ba - belief_.ba).norm();
  if (!(ba_change < kAccelBiasSigmas * belief_.ba_sigma_mps2))
    return refuse(guess, StartRefusal::kBias, ba_change);
  if (!(q.scale_sigma <= config_.init_max_scale_sigma))
    return refuse(guess, StartRefusal::kWeakScale, q.scale_sigma);
  if (!(std::abs(q.gravity_error_mps2) <
        kGravitySlack_mps2 + kGravitySigmas * q.gravity_sigma_mps2))
    return refuse(guess, StartRefusal::kGravity, config_.gravity_mps2 + q.gravity_error_mps2);
  return true;
}

bool Search::start_moving(StartGuess& guess) noexcept {
  MotionState x;
  x.ba = belief_.ba;
  x.bg = belief_.bg + gyro_bias_.find(tracks_, path_, rig_, config_, belief_.bg_sigma_radps);
  if (path_.integrate(frames_, imu_, x.bg, x.ba) != StartRefusal::kNone)
    return refuse(guess, StartRefusal::kNoImu, 0);
  const double parallax_px = median_motion_px(tracks_, path_, rig_, true);
  if (!(parallax_px > kMinParallaxSigmas * config_.point_sigma_px))
    return refuse(guess, StartRefusal::kTooLittleParallax, parallax_px);
  const std::optional<Vector6d> linear = linear_.best(tracks_, path_, rig_, config_);
  if (!linear) return refuse(guess, StartRefusal::kNoSolution, 0);
  x.v_0 = linear->head<3>();
  x.g_0 = linear->tail<3>();
  if (!refiner_.refine(frames_, imu_, rig_, config_, belief_, tracks_, path_, x))
    return refuse(guess, StartRefusal::kWeakScale, 1.0);  // a valley without a floor
  const MotionQuality quality = refiner_.judge(rig_, config_, belief_, tracks_, path_, x);
  if (!accept(quality, x, guess)) return false;
  write_states(x, guess);
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    if (refiner_.inlier(i) && !guess.inliers.push_back(tracks_.id(i))) break;
  guess.scale_sigma = quality.scale_sigma;
  guess.inlier_share = quality.inlier_share;
  guess.error_sigmas = quality.error_sigmas;
  guess.detail = quality.scale_sigma;
  guess.refusal = StartRefusal::kNone;
  return true;
}

void Search::run(StartGuess& guess) noexcept {
  if (!enough_data(guess)) return;
  if (start_still(guess) || guess.refusal == StartRefusal::kGravity) return;
  (void)start_moving(guess);
}

}  // namespace
}  // namespace start

std::string_view to_string(StartRefusal refusal) noexcept {
  switch (refusal) {
    case StartRefusal::kNone: return "started";
    case StartRefusal::kNoImu:
      return "no inertial data cover the frames: check that the IMU is connected and shares the "
             "frames' clock";
    case StartRefusal::kImuGap:
      return "inertial samples are missing among the frames: check the IMU's link and rate";
    case StartRefusal::kTooFewFrames: return "too few frames so far: wait for more";
    case StartRefusal::kTooShort: return "the frames span too little time so far: keep moving";
    case StartRefusal::kTooFewTracks:
      return "too few points stay in view: show more texture, more light or turn more slowly";
    case StartRefusal::kTooLittleParallax:
      return "the points hardly shift against each other: move the camera sideways, or hold it "
             "quite still";
    case StartRefusal::kWeakScale:
      return "the motion does not tell how large the scene is: change speed or direction";
    case StartRefusal::kGravity:
      return "gravity comes out with a wrong magnitude: check the accelerometer's unit, range and "
             "calibration";
    case StartRefusal::kOutliers:
      return "too few points agree on one motion: look at more of the scene that stands still";
    case StartRefusal::kBias:
      return "the IMU's biases come out implausibly large: check its axes, units and place on the "
             "camera";
    case StartRefusal::kUnconfirmed:
      return "a motion is found and being checked with further frames: keep moving";
    case StartRefusal::kNoSolution:
      return "the motion cannot be solved for: move in more than one direction";
  }
  return "unknown";
}

StartBelief no_belief(const BackendConfig& config) noexcept {
  StartBelief belief;
  belief.bg_sigma_radps = config.gyro_bias_sigma_radps;
  belief.ba_sigma_mps2 = config.accel_bias_sigma_mps2;
  return belief;
}

StartGuess guess_start(const StartFrames& frames, const ImuHistory& imu, const RigCalibration& rig,
                       const BackendConfig& config, const StartBelief& belief) noexcept {
  StartGuess guess;
  start::Search search(frames, imu, rig, config, belief);
  search.run(guess);
  return guess;
}

StartGuess guess_start(const StartFrames& frames, const ImuHistory& imu, const RigCalibration& rig,
                       const BackendConfig& config) noexcept {
  return guess_start(frames, imu, rig, config, no_belief(config));
}

}  // namespace pled
