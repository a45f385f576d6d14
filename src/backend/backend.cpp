#include "pled_vins/backend/backend.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "src/backend/arrival_check.hpp"
#include "src/backend/credible.hpp"

namespace pled {
namespace {

constexpr double kMaxGyroBias_radps = 1.0;
constexpr double kMaxAccelBias_mps2 = 3.0;
constexpr double kMaxSpeed_mps = 50.0;
constexpr double kMaxJump_m = 1.0;     ///< from the inertial prediction, within one frame
constexpr std::size_t kFewPoints = 8;  ///< below, vision does not hold the pose
constexpr Duration kMaxWeak = Duration::from_ms(1500);
constexpr Duration kDegradedAfterGap = Duration::from_ms(1000);

std::array<double, 3> to_array(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// A rough picture must not be taken for a divergence.
constexpr double kMostResidual_px = 3.5;

BackendConfig for_start(BackendConfig config) {
  config.point_sigma_px = std::max(config.point_sigma_px, config.start_sigma_px);
  config.event_point_sigma_px = std::max(config.event_point_sigma_px, config.start_sigma_px);
  config.line_sigma_px = std::max(config.line_sigma_px, config.start_sigma_px);
  return config;
}

ImuNoise inertial_model(ImuNoise noise, const BackendConfig& config) {
  const double factor = config.imu_noise_scale;
  noise.accel_density *= factor;
  noise.accel_walk *= factor;
  noise.gyro_density *= factor;
  noise.gyro_walk *= factor;
  noise.gravity_mps2 = config.gravity_mps2;
  return noise;
}

}  // namespace

Backend::Backend(const BackendConfig& config, const RigCalibration& rig,
                 WindowSolver& solver) noexcept
    : config_(config),
      start_config_(for_start(config)),
      rig_(rig),
      noise_(inertial_model(rig.imu, config)),
      settings_(make_factor_settings(config_, rig_)),
      feature_noise_({config.point_sigma_px, config.event_point_sigma_px, config.line_sigma_px}),
      solver_(solver),
      book_(rig_, settings_, static_cast<std::size_t>(config.min_observations)),
      line_book_(rig_, settings_, static_cast<std::size_t>(config.min_line_observations)),
      bootstrap_(start_config_, rig_, noise_, settings_),
      still_(rig_) {
  const Pose& T = rig_.cameras[rig_.frame_camera].T_body_cam;
  window_.rig_state = {T, T, T, 0.0, 0.0};
  belief_.bg_sigma_radps = config.gyro_bias_sigma_radps;
  belief_.ba_sigma_mps2 = config.accel_bias_sigma_mps2;
}

void Backend::set_rules(LivePointRule rule, bool first_estimates) noexcept {
  marginaliser_.set_rule(rule);
  settings_.first_estimates = first_estimates;
}

void Backend::start_from(const NavState& mean, const Vector15d& sigma) noexcept {
  StatePrior prior;
  prior.mean = mean;
  prior.sqrt_information = sigma.cwiseInverse().asDiagonal();
  given_start_ = prior;
}

void Backend::process(const FrameMeasurement& frame, const ImuHistory& imu,
                      BackendOutput& out) noexcept {
  out = BackendOutput{};
  begin_weights(frame, out);
  out.pose.t = frame.t;
  out.pose.stamp_ns = frame.stamp_ns;
  out.pose.reset_counter = reset_counter_;
  if (last_frame_t_.us != 0 && !(frame.t > last_frame_t_)) {
    ++faults_.frames_refused;
    return;
  }
  offer(frame);
  if (!tracking_ || !track(offered_, imu, out)) begin(offered_, imu, out);
  end_weights(out);
  last_frame_t_ = frame.t;
}

void Backend::begin_weights(const FrameMeasurement& frame, BackendOutput& out) const noexcept {
  const auto first = [this](const auto& feature) {
    FeatureWeight weight;
    weight.id = feature.id;
    weight.w_temporal = feature.w_temporal;
    if (!feature.inlier) weight.w = 0.0;
    return weight;
  };
  for (const PointMeasurement& point : frame.points) (void)out.weights.push_back(first(point));
  for (const LineMeasurement& line : frame.lines) (void)out.line_weights.push_back(first(line));
}

/// Keeps the frame with those of its points that are meant for the solver.
void Backend::offer(const FrameMeasurement& frame) noexcept {
  offered_ = frame;
  offered_.points.clear();
  for (const PointMeasurement& point : frame.points)
    if (point.for_solver) (void)offered_.points.push_back(point);
}

bool Backend::append_state(const FrameMeasurement& frame, const ImuHistory& imu) noexcept {
  const NavState last = window_.newest().x;
  WindowState* state = window_.push_state();
  if (!state) return false;
  bool has_gap = false;
  (void)state->imu.resize(state->imu.capacity());
  const std::size_t n = imu.interval(last.t, frame.t, state->imu.span(), has_gap);
  (void)state->imu.resize(n);
  state->has_imu = n >= 2 && !has_gap &&
                   state->preintegration.integrate(state->imu.span(), last.bg, last.ba, noise_) &&
                   credible(state->preintegration, last);
  if (state->has_imu) {
    state->x = state->preintegration.predict(last);
    state->x.t = frame.t;
    return true;
  }
  state->imu.clear();
  state->x = last;
  state->x.t = frame.t;
  bridge_gap(last, *state);
  return false;
}

/// Over a hole in the inertial data a state is only loosely bound to the one before, by what a
/// body can do in that time; the points that are still seen must hold it.
void Backend::bridge_gap(const NavState& last, WindowState& state) noexcept {
  const double dt_s = (state.x.t - last.t).seconds();
  state.x.p_wb += last.v_wb * dt_s;
  constexpr double kAccel_mps2 = 4.0;
  constexpr double kTurn_radps = 1.0;
  Vector15d sigma;
  sigma.segment<3>(0).setConstant(0.02 + 0.5 * kAccel_mps2 * dt_s * dt_s);
  sigma.segment<3>(3).setConstant(0.02 + kTurn_radps * dt_s);
  sigma.segment<3>(6).setConstant(0.1 + kAccel_mps2 * dt_s);
  sigma.segment<3>(9).setConstant(0.005 + noise_.gyro_walk * std::sqrt(dt_s));
  sigma.segment<3>(12).setConstant(0.05 + noise_.accel_walk * std::sqrt(dt_s));
  StatePrior prior;
  prior.mean = state.x;
  prior.sqrt_information = sigma.cwiseInverse().asDiagonal();
  state.prior = prior;
}

/// Steps for the newest frame. Scale comes by a long flat valley and needs many; once motion has
/// told it, each frame brings little news. Ours: half the steps then lost no accuracy on simulated
/// flights.
int Backend::solver_steps(Duration since_last) noexcept {
  if (!window_.newest().still) settling_left_ = settling_left_ - since_last;
  if (settling_left_ > Duration{}) return config_.max_iterations;
  return std::min(config_.max_iterations, config_.settled_iterations);
}

bool Backend::track(const FrameMeasurement& frame, const ImuHistory& imu,
                    BackendOutput& out) noexcept {
  const NavState last = window_.newest().x;
  const bool bridged = !append_state(frame, imu);
  const NavState predicted = window_.newest().x;
  if (bridged) {
    if (!bridging_) {  // one hole, however many frames fall into it
      ++faults_.imu_gaps;
      ++reset_counter_;
    }
    degraded_until_ = frame.t + kDegradedAfterGap;
    settling_left_ = kSettling;
  }
  bridging_ = bridged;
  const std::size_t newest = window_.size() - 1;
  book_.observe(window_, frame, newest);
  line_book_.observe(window_, frame, newest);
  if (!bridged) turn_away_movers(window_, rig_, settings_);
  note_standstill(frame);
  out.points_in_solver = static_cast<std::uint16_t>(book_.prepare(window_));
  out.lines_in_solver = static_cast<std::uint16_t>(line_book_.prepare(window_));
  const SolveSummary summary =
      solver_.solve({window_, rig_, settings_}, {.max_iterations = solver_steps(frame.t - last.t)});
  out.iterations = summary.iterations;
  out.mean_reprojection_px = book_.judge(window_);
  line_book_.judge(window_);
  feature_noise_.observe(window_, rig_, settings_);
  const Verdict verdict = check(bridged ? window_.newest().x : predicted, summary, out);
  if (verdict == Verdict::kDiverged) {
    ++faults_.divergences;
    lose(bridged ? predicted : last, last.t);
    return false;
  }
  const bool degraded = verdict == Verdict::kWeak || frame.t < degraded_until_;
  write_weights(out);
  write_pose(window_.newest().x, frame,
             degraded ? EstimatorStatus::kDegraded : EstimatorStatus::kTracking, out);
  WindowState& state = window_.newest();
  state.keyframe = state.keyframe || is_keyframe(frame);
  out.keyframe = state.keyframe;
  repropagate();
  slide();
  set_feature_noise(settings_, rig_, feature_noise_.sigmas_px());
  return true;
}

void Backend::note_standstill(const FrameMeasurement& frame) noexcept {
  WindowState& state = window_.newest();
  if (!state.has_imu || !still_.update(frame, state.imu.span(), state.x)) return;
  state.still = true;
  constexpr double kWrongTogether_s = 0.5;
  state.still_share = std::min(1.0, state.preintegration.dt_s() / kWrongTogether_s);
  // Bound to the first keyframe of this standstill, so that nothing adds up.
  for (std::size_t i = window_.size() - 1; i-- > 0;) {
    if (window_.state(i).x.t < still_.since()) break;
    if (window_.state(i).keyframe && window_.state(i).still) state.still_as = static_cast<int>(i);
  }
  if (state.still_as < 0) state.keyframe = true;
}

/// Integrates an interval anew once its biases have moved away from where it was integrated:
/// the first-order correction is then no longer exact.
void Backend::repropagate() noexcept {
  constexpr double kGyro_radps = 5e-4, kAccel_mps2 = 5e-3;
  for (std::size_t i = 1; i < window_.size(); ++i) {
    WindowState& s = window_.state(i);
    if (!s.has_imu) continue;
    const NavState& from = window_.state(i - 1).x;
    const bool moved = (from.bg - s.preintegration.linearised_bg()).norm() > kGyro_radps ||
                       (from.ba - s.preintegration.linearised_ba()).norm() > kAccel_mps2;
    if (moved) (void)s.preintegration.integrate(s.imu.span(), from.bg, from.ba, noise_);
  }
}

Backend::Verdict Backend::check(const NavState& predicted, const SolveSummary& summary,
                                const BackendOutput& out) noexcept {
  const NavState& x = window_.newest().x;
  const bool sane = summary.ok && x.bg.norm() < kMaxGyroBias_radps &&
                    x.ba.norm() < kMaxAccelBias_mps2 && x.v_wb.norm() < kMaxSpeed_mps &&
                    x.q_wb.coeffs().allFinite() && (x.p_wb - predicted.p_wb).norm() < kMaxJump_m;
  if (!sane) return Verdict::kDiverged;
  std::size_t held = 0;
  const std::size_t newest = window_.size() - 1;
  for (const Landmark& l : window_.landmarks)
    held += l.in_solver && !l.rejected && l.observations.back().state == newest;
  const bool enough = held >= kFewPoints || window_.newest().still;
  if (enough && out.mean_reprojection_px < kMostResidual_px) {
    weak_since_.reset();
    return Verdict::kGood;
  }
  if (!weak_since_) weak_since_ = x.t;
  return x.t - *weak_since_ > kMaxWeak ? Verdict::kDiverged : Verdict::kWeak;
}

void Backend::write_pose(const NavState& x, const FrameMeasurement& frame, EstimatorStatus status,
                         BackendOutput& out) const noexcept {
  out.has_pose = true;
  out.pose.t = frame.t;
  out.pose.stamp_ns = frame.stamp_ns;
  out.pose.p_world_body_m = to_array(x.p_wb);
  out.pose.q_world_body_xyzw = {x.q_wb.x(), x.q_wb.y(), x.q_wb.z(), x.q_wb.w()};
  out.pose.v_world_body_mps = to_array(x.v_wb);
  out.pose.gyro_bias_radps = to_array(x.bg);
  out.pose.accel_bias_mps2 = to_array(x.ba);
  out.pose.status = status;
  out.pose.reset_counter = reset_counter_;
}

void Backend::write_weights(BackendOutput& out) noexcept {
  const auto write = [](const auto* landmark, FeatureWeight& weight) {
    if (!landmark || weight.w == 0.0) return;  // those that are no inliers
    weight.observations = static_cast<std::uint16_t>(landmark->observations.size());
    weight.used = landmark->in_solver;
    if (landmark->strikes > 0) weight.w = 0.0;
    if (std::isnan(landmark->weight) || landmark->strikes > 0) return;  // not weighed
    weight.w_geometric = landmark->reliability.w_geometric;
    weight.w = landmark->rejected ? 0.0 : landmark->reliability.w;
  };
  for (FeatureWeight& weight : out.weights) write(window_.find(weight.id), weight);
  for (FeatureWeight& weight : out.line_weights) write(window_.find_line(weight.id), weight);
}

/// What geometry says nothing of is believed as time tells.
void Backend::end_weights(BackendOutput& out) const noexcept {
  if (config_.fusion.mode != FusionMode::kPrior) return;
  for (const std::span<FeatureWeight> weights : {out.weights.span(), out.line_weights.span()})
    for (FeatureWeight& weight : weights)
      if (std::isnan(weight.w)) weight.w = weight.w_temporal;
}

std::optional<Matrix6d> Backend::newest_pose_covariance() noexcept {
  if (!tracking_ || window_.size() == 0) return std::nullopt;
  equations_.add_all(window_, rig_, settings_);
  const int row = static_cast<int>(window_.size() - 1) * kStateDim;
  const Eigen::LLT<PriorMatrix> llt(equations_.H());
  if (llt.info() != Eigen::Success) return std::nullopt;
  Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMaxWindowDim, 6> columns;
  columns.setZero(equations_.dim(), 6);
  columns.middleRows<6>(row).setIdentity();
  llt.solveInPlace(columns);
  const Matrix6d covariance = columns.middleRows<6>(row);
  if (!covariance.allFinite()) return std::nullopt;
  return covariance;
}

}  // namespace pled
