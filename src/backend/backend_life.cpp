// Starting, giving up and going on.

#include <cmath>

#include <Eigen/Geometry>

#include "pled_vins/backend/backend.hpp"
#include "src/backend/credible.hpp"

namespace pled {
namespace {

constexpr Duration kMaxCoast = Duration::from_ms(1000);

}  // namespace

void Backend::begin(const FrameMeasurement& frame, const ImuHistory& imu,
                    BackendOutput& out) noexcept {
  if (given_start_) {
    window_.clear();
    WindowState& state = *window_.push_state();
    state.x = given_start_->mean;
    state.keyframe = true;
    state.prior = given_start_;
    given_start_.reset();
    book_.observe(window_, frame, 0);
    line_book_.observe(window_, frame, 0);
    out.refusal = StartRefusal::kNone;
  } else {
    coast(frame, imu, out);
    set_feature_noise(settings_, rig_,
                      {start_config_.point_sigma_px, start_config_.event_point_sigma_px,
                       start_config_.line_sigma_px});
    out.refusal = bootstrap_.attempt(frame, imu, belief_, book_, solver_, window_);
    out.refusal_detail = bootstrap_.detail();
    if (out.refusal != StartRefusal::kNone) return;
    align_to_handover();
  }
  tracking_ = true;
  settling_left_ = kSettling;
  feature_noise_.reset();
  set_feature_noise(settings_, rig_, feature_noise_.sigmas_px());
  weak_since_.reset();
  still_.reset();
  const WindowState& newest = window_.newest();
  if (newest.still)
    still_.begin(frame, newest.imu.span().last(std::min<std::size_t>(newest.imu.size(), 12)),
                 newest.x, window_.state(0).x.t);
  out.keyframe = true;
  write_weights(out);
  write_pose(window_.newest().x, frame, EstimatorStatus::kTracking, out);
}

/// Moves a fresh window by position and yaw so that its newest state is where the last life of the
/// estimator, carried on by the IMU, says: the output frame continues.
void Backend::align_to_handover() noexcept {
  if (!handover_) return;
  const NavState& newest = window_.newest().x;
  const Eigen::Quaterniond turn = handover_->q_wb * newest.q_wb.conjugate();
  const Eigen::Matrix3d R = turn.toRotationMatrix();
  const double yaw_rad = std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
  const Eigen::Quaterniond yaw(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d shift = handover_->p_wb - yaw * newest.p_wb;
  const auto move = [&](NavState& x) {
    x.p_wb = yaw * x.p_wb + shift;
    x.q_wb = (yaw * x.q_wb).normalized();
    x.v_wb = yaw * x.v_wb;
  };
  for (std::size_t i = 0; i < window_.size(); ++i) {
    move(window_.state(i).x);
    // The tangent of a rotation is in the body frame, so only the mean of a prior moves.
    if (window_.state(i).prior) move(window_.state(i).prior->mean);
  }
  for (LineLandmark& line : window_.lines) line.has_line = false;  // of the old frame
  handover_.reset();
}

void Backend::forget_frames() noexcept {
  if (tracking_ || handover_) return;
  bootstrap_.clear();
  last_frame_t_ = Timestamp{};
}

/// Gives the window up but not what is known: gravity and heading by the attitude, biases, and
/// the last place and speed.
void Backend::lose(const NavState& last, Timestamp t) noexcept {
  tracking_ = false;
  ++reset_counter_;
  lost_at_ = t;
  handover_ = last;
  const bool usable = last.p_wb.allFinite() && last.v_wb.allFinite() &&
                      last.q_wb.coeffs().allFinite() && last.bg.allFinite() && last.ba.allFinite();
  if (!usable) handover_ = NavState{};
  if (usable && last.bg.norm() < belief_.bg_sigma_radps * 5 &&
      last.ba.norm() < belief_.ba_sigma_mps2 * 5) {
    belief_.bg = last.bg;
    belief_.ba = last.ba;
  }
  window_.clear();
  bootstrap_.clear();
}

void Backend::restart() noexcept {
  if (tracking_) lose(window_.newest().x, window_.newest().x.t);
  bootstrap_.clear();
  last_frame_t_ = lost_at_ = degraded_until_ = Timestamp{};
  if (handover_) handover_->t = Timestamp{};
}

/// Carries the last good state on by the IMU alone, and gives it out for a short while. After that
/// only the attitude goes on, for the heading to continue: a place found by the IMU alone is soon
/// anywhere.
void Backend::coast(const FrameMeasurement& frame, const ImuHistory& imu,
                    BackendOutput& out) noexcept {
  if (!handover_ || !(frame.t > handover_->t)) return;
  bool has_gap = false;
  (void)coast_imu_.resize(coast_imu_.capacity());
  const std::size_t n = imu.interval(handover_->t, frame.t, coast_imu_.span(), has_gap);
  (void)coast_imu_.resize(n);
  Preintegration step;
  const bool bounded = frame.t - lost_at_ <= kMaxCoast;
  const bool measured = n >= 2 && !has_gap &&
                        step.integrate(coast_imu_.span(), handover_->bg, handover_->ba, noise_) &&
                        credible(step, *handover_);
  const NavState last = *handover_;
  if (measured) *handover_ = step.predict(last);
  if (!bounded) {
    handover_->p_wb = last.p_wb;
    handover_->v_wb.setZero();
  } else if (!measured) {
    handover_->p_wb += last.v_wb * (frame.t - last.t).seconds();
  }
  handover_->t = frame.t;
  if (!bounded) {
    out.pose.status = EstimatorStatus::kLost;
    return;
  }
  write_pose(*handover_, frame, EstimatorStatus::kDegraded, out);
}

}  // namespace pled
