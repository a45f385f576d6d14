#include "pled_vins/backend/bootstrap.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace pled {
namespace {

constexpr double kGaugePosition_m = 1e-3;
constexpr double kGaugeYaw_rad = 5e-4;
constexpr double kTilt_rad = 0.5;
constexpr double kSpeed_mps = 20.0;
constexpr int kIterations = 12;
constexpr std::size_t kMinPoints = 12;
constexpr std::size_t kMaxStates = limits::kWindowStates - 1;  ///< leaves room for the next frame
constexpr double kMaxMeanSigmas = 2.5;  ///< rms residual of one axis over the accepted points
constexpr double kBiasSigmas = 4.0;
constexpr double kMinAgreeing = 0.6;      ///< of the points solved, with weight above one half
constexpr double kMaxScaleChange = 0.25;  ///< from the guess to the solved window
// A wrong motion (of a car that fills the view) drifts from frame to frame; the true one stays.
constexpr Duration kConfirmAfter = Duration::from_ms(90);
constexpr Duration kConfirmWithin = Duration::from_ms(400);
constexpr double kConfirmSpeed = 0.1;  ///< relative
constexpr double kSlowest_mps = 0.3;
constexpr double kConfirmTilt_rad = 0.03;
// What a short look tells of the scale is wrong by more than it claims, since errors that last have
// had no time to show; and who waits long puts up with less. Ours, chosen on simulated traffic.
constexpr double kFirstDemand = 0.5;  ///< of init_max_scale_sigma, until kFirstLook_s
constexpr double kLastDemand = 2.0;   ///< from kPatienceEnds_s on
constexpr double kFirstLook_s = 0.4;
constexpr double kPatienceEnds_s = 2.4;

}  // namespace

StatePrior gauge_prior(const NavState& mean, const StartBelief& belief) noexcept {
  StatePrior prior;
  prior.mean = mean;
  prior.mean.bg = belief.bg;
  prior.mean.ba = belief.ba;
  Matrix15d& S = prior.sqrt_information;
  S.diagonal().segment<3>(0).setConstant(1.0 / kGaugePosition_m);
  // Yaw is a turn about the vertical, which the body sees along z_b.
  const Eigen::Vector3d z_b = mean.q_wb.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Matrix3d vertical = z_b * z_b.transpose();
  S.block<3, 3>(3, 3) =
      vertical / kGaugeYaw_rad + (Eigen::Matrix3d::Identity() - vertical) / kTilt_rad;
  S.diagonal().segment<3>(6).setConstant(1.0 / kSpeed_mps);
  S.diagonal().segment<3>(9).setConstant(1.0 / belief.bg_sigma_radps);
  S.diagonal().segment<3>(12).setConstant(1.0 / belief.ba_sigma_mps2);
  return prior;
}

void Bootstrap::clear() noexcept {
  frames_.clear();
  num_found_ = 0;
}

bool Bootstrap::spaced() const noexcept {
  const std::size_t n = frames_.size();
  if (n < 2) return true;
  const Duration step{(frames_[n - 1].t - frames_[0].t).us /
                      static_cast<std::int64_t>(limits::kInitFrames)};
  return frames_[n - 1].t - frames_[n - 2].t >= step - Duration{1000};
}

/// Forgets the frame inside whose neighbours are closest: the rest stay about evenly spread.
void Bootstrap::thin() noexcept {
  std::size_t closest = 1;
  for (std::size_t i = 2; i + 1 < frames_.size(); ++i)
    if (frames_[i + 1].t - frames_[i - 1].t < frames_[closest + 1].t - frames_[closest - 1].t)
      closest = i;
  frames_.erase(closest);
}

void Bootstrap::collect(const FrameMeasurement& frame) noexcept {
  const Duration longest = Duration::from_s(config_.init_max_span_s);
  if (frames_.empty()) collecting_since_ = frame.t;
  // The newest frame is always the last; the one before gives way when it is too close
  // to its predecessor.
  if (!spaced()) frames_.pop_back();
  while (!frames_.empty() && frame.t - frames_.front().t > longest) frames_.erase(0);
  if (frames_.full()) thin();
  (void)frames_.push_back(frame);
}

bool Bootstrap::fill(const StartGuess& guess, const ImuHistory& imu, const StartBelief& belief,
                     const LandmarkBook& book, SlidingWindow& window) noexcept {
  const std::size_t last = frames_.size() - 1;
  const std::size_t states = guess.stationary ? 2 : std::min(frames_.size(), kMaxStates);
  for (std::size_t k = 0; k < states; ++k) {
    const std::size_t i = k * last / (states - 1);
    WindowState* state = window.push_state();
    if (!state) return false;
    state->x = guess.states[i];
    state->keyframe = true;
    if (guess.stationary) {
      state->still = true;
      state->still_as = k == 0 ? -1 : 0;
      state->keyframe = k == 0;
    }
    if (k == 0) {
      state->prior = gauge_prior(state->x, belief);
    } else {
      bool has_gap = false;
      (void)state->imu.resize(state->imu.capacity());
      const std::size_t n =
          imu.interval(window.state(k - 1).x.t, state->x.t, state->imu.span(), has_gap);
      (void)state->imu.resize(n);
      if (n < 2 || has_gap) return false;
      state->has_imu =
          state->preintegration.integrate(state->imu.span(), state->x.bg, state->x.ba, noise_);
      if (!state->has_imu) return false;
    }
    agreed_ = frames_[i];
    if (!guess.inliers.empty()) {
      agreed_.points.clear();
      for (const PointMeasurement& p : frames_[i].points)
        if (std::find(guess.inliers.begin(), guess.inliers.end(), p.id) != guess.inliers.end())
          (void)agreed_.points.push_back(p);
    }
    book.observe(window, agreed_, k);
  }
  return true;
}

bool Bootstrap::confirmed(const StartGuess& guess) noexcept {
  const NavState& now = guess.states.back();
  bool agrees = false;
  for (std::size_t i = 0; i < num_found_ && !agrees; ++i) {
    const NavState& then = found_[i];
    if (now.t - then.t < kConfirmAfter || now.t - then.t > kConfirmWithin) continue;
    for (const NavState& again : guess.states) {
      if (again.t != then.t) continue;
      const Eigen::Quaterniond q_b_w = again.q_wb.conjugate();
      const Eigen::Quaterniond q_b_then = then.q_wb.conjugate();
      const Eigen::Vector3d v = q_b_w * again.v_wb;
      const double speed_mps = std::max(kSlowest_mps, v.norm());
      const Eigen::Vector3d up = q_b_w * Eigen::Vector3d::UnitZ();
      agrees = (v - q_b_then * then.v_wb).norm() < kConfirmSpeed * speed_mps &&
               (up - q_b_then * Eigen::Vector3d::UnitZ()).norm() < kConfirmTilt_rad;
    }
  }
  if (num_found_ == found_.size()) {
    std::move(found_.begin() + 1, found_.end(), found_.begin());
    --num_found_;
  }
  found_[num_found_++] = now;
  return agrees;
}

StartRefusal Bootstrap::refine(const StartBelief& belief, bool stationary, LandmarkBook& book,
                               WindowSolver& solver, SlidingWindow& window) noexcept {
  const WindowProblem problem{window, rig_, settings_};
  double rms_px = 0;
  for (int round = 0; round < 2; ++round) {  // the second without the outliers of the first
    const std::size_t points = book.prepare(window);
    if (!stationary && points < kMinPoints) {
      detail_ = static_cast<double>(points);
      return StartRefusal::kTooFewTracks;
    }
    if (!solver.solve(problem, {.max_iterations = kIterations}).ok)
      return StartRefusal::kNoSolution;
    for (std::size_t k = 1; k < window.size(); ++k) {
      WindowState& s = window.state(k);
      (void)s.preintegration.integrate(s.imu.span(), window.state(k - 1).x.bg,
                                       window.state(k - 1).x.ba, noise_);
    }
    rms_px = book.judge(window);
  }
  const NavState& x = window.newest().x;
  detail_ = (x.bg - belief.bg).norm();
  if (!(detail_ < kBiasSigmas * belief.bg_sigma_radps)) return StartRefusal::kBias;
  detail_ = (x.ba - belief.ba).norm();
  if (!(detail_ < kBiasSigmas * belief.ba_sigma_mps2)) return StartRefusal::kBias;
  if (stationary) return StartRefusal::kNone;
  detail_ = rms_px;
  if (!(rms_px < kMaxMeanSigmas * config_.point_sigma_px)) return StartRefusal::kOutliers;
  detail_ = agreeing_share(window);
  return detail_ >= kMinAgreeing ? StartRefusal::kNone : StartRefusal::kOutliers;
}

/// How much longer the way through the window has become, relative.
double Bootstrap::scale_change(const StartGuess& guess, const SlidingWindow& window) noexcept {
  const double guessed_m = (guess.states.back().p_wb - guess.states.front().p_wb).norm();
  const double solved_m = (window.newest().x.p_wb - window.state(0).x.p_wb).norm();
  return solved_m / guessed_m - 1.0;
}

double Bootstrap::agreeing_share(const SlidingWindow& window) noexcept {
  double solved = 0;
  double agreeing = 0;
  for (const Landmark& landmark : window.landmarks) {
    if (!landmark.in_solver) continue;
    solved += 1;
    agreeing += landmark.weight > 0.5 ? 1 : 0;
  }
  return agreeing / std::max(solved, 1.0);
}

double Bootstrap::accepted_scale_sigma() const noexcept {
  const double waited_s = (frames_.back().t - collecting_since_).seconds();
  const double share = (waited_s - kFirstLook_s) / (kPatienceEnds_s - kFirstLook_s);
  return config_.init_max_scale_sigma *
         std::lerp(kFirstDemand, kLastDemand, std::clamp(share, 0.0, 1.0));
}

StartRefusal Bootstrap::attempt(const FrameMeasurement& frame, const ImuHistory& imu,
                                const StartBelief& belief, LandmarkBook& book, WindowSolver& solver,
                                SlidingWindow& window) noexcept {
  collect(frame);
  window.clear();
  if (!spaced()) return last_refusal_;  // it will give way to the next: nothing new to learn
  last_refusal_ = start(imu, belief, book, solver, window);
  if (last_refusal_ != StartRefusal::kNone) window.clear();
  return last_refusal_;
}

StartRefusal Bootstrap::start(const ImuHistory& imu, const StartBelief& belief, LandmarkBook& book,
                              WindowSolver& solver, SlidingWindow& window) noexcept {
  BackendConfig config = config_;
  config.init_max_scale_sigma = accepted_scale_sigma();
  const StartGuess guess = guess_start(frames_, imu, rig_, config, belief);
  detail_ = guess.detail;
  if (guess.refusal != StartRefusal::kNone) return guess.refusal;
  if (!guess.stationary && !confirmed(guess)) return StartRefusal::kUnconfirmed;
  if (guess.states.size() != frames_.size() || frames_.size() < 2 ||
      !fill(guess, imu, belief, book, window))
    return StartRefusal::kNoSolution;
  const StartRefusal refusal = refine(belief, guess.stationary, book, solver, window);
  if (refusal != StartRefusal::kNone || guess.stationary) return refusal;
  const double change = scale_change(guess, window);
  if (std::abs(change) < kMaxScaleChange) return StartRefusal::kNone;
  detail_ = change;
  return StartRefusal::kWeakScale;
}

}  // namespace pled
