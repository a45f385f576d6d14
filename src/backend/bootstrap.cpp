#include "pled_vins/backend/bootstrap.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace pled {
namespace {

constexpr double kGaugePosition_m = 1e-3;
constexpr double kGaugeYaw_rad = 5e-4;
constexpr double kTilt_rad = 0.5;
constexpr double kSpeed_mps = 20.0;
constexpr int kIterations = 12;
constexpr std::size_t kMinPoints = 12;
constexpr double kMaxMeanSigmas = 2.5;  ///< rms residual of one axis over the accepted points
constexpr double kBiasSigmas = 4.0;

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

void Bootstrap::collect(const FrameMeasurement& frame) noexcept {
  const Duration longest = Duration::from_s(config_.init_max_span_s);
  const Duration step{longest.us / static_cast<std::int64_t>(limits::kInitFrames - 1)};
  // The newest frame is always the last; the one before gives way when it is too close
  // to its predecessor.
  const std::size_t n = frames_.size();
  if (n >= 2 && frames_[n - 1].t - frames_[n - 2].t < step - Duration{1000}) frames_.pop_back();
  while (!frames_.empty() && (frames_.full() || frame.t - frames_.front().t > longest))
    frames_.erase(0);
  (void)frames_.push_back(frame);
}

bool Bootstrap::fill(const StartGuess& guess, const ImuHistory& imu, const StartBelief& belief,
                     const LandmarkBook& book, SlidingWindow& window) noexcept {
  const std::size_t last = frames_.size() - 1;
  const std::size_t states = guess.stationary ? 2 : std::min(frames_.size(), limits::kWindowStates);
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

double Bootstrap::scale_sigma(const SlidingWindow& window) noexcept {
  equations_.add_all(window, rig_, settings_);
  const Eigen::LLT<PriorMatrix> llt(equations_.H());
  if (llt.info() != Eigen::Success) return std::nan("");
  const std::size_t newest = window.size() - 1;
  const Eigen::Vector3d way = window.state(newest).x.p_wb - window.state(0).x.p_wb;
  const double distance = way.norm();
  if (!(distance > 1e-6)) return std::nan("");
  PriorVector direction = PriorVector::Zero(equations_.dim());
  direction.segment<3>(static_cast<int>(newest) * kStateDim) = way / distance;
  direction.segment<3>(0) = -way / distance;
  const PriorVector solved = llt.solve(direction);
  return std::sqrt(direction.dot(solved)) / distance;
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
  detail_ = scale_sigma(window);
  if (!(detail_ < config_.init_max_scale_sigma)) return StartRefusal::kWeakScale;
  return StartRefusal::kNone;
}

StartRefusal Bootstrap::attempt(const FrameMeasurement& frame, const ImuHistory& imu,
                                const StartBelief& belief, LandmarkBook& book, WindowSolver& solver,
                                SlidingWindow& window) noexcept {
  collect(frame);
  window.clear();
  const StartGuess guess = guess_start(frames_, imu, rig_, config_);
  detail_ = guess.detail;
  if (guess.refusal != StartRefusal::kNone) return guess.refusal;
  StartRefusal refusal = StartRefusal::kNoSolution;
  if (guess.states.size() == frames_.size() && frames_.size() >= 2 &&
      fill(guess, imu, belief, book, window))
    refusal = refine(belief, guess.stationary, book, solver, window);
  if (refusal != StartRefusal::kNone) window.clear();
  return refusal;
}

}  // namespace pled
