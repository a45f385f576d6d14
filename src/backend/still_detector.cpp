#include "pled_vins/backend/still_detector.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace pled {
namespace {

constexpr double kPlace_px = 0.8;  ///< a point within this distance has not moved
constexpr double kShare = 0.6;     ///< of points that must not have moved
constexpr std::size_t kMinCommon = 10;
constexpr Duration kLeastAge = Duration::from_ms(200);  ///< of a place before it says anything
// What all points do together is seen far more exactly than the way of one.
constexpr double kTogether_px = 0.2;
constexpr double kTogetherNoise_px = 1.0;   ///< over the root of the number of points
constexpr double kGyroMargin_radps = 0.01;  ///< on top of the sensor's noise
constexpr double kAccelMargin_mps2 = 0.06;
// Motors on, propellers idle: EuRoC shows 0.1 and 1.3. So much may be motion as well; the estimate
// must then say that it is none.
constexpr double kGyroShake_radps = 0.3;
constexpr double kAccelShake_mps2 = 3.0;
constexpr double kShakenSpeed_mps = 0.1;
constexpr double kShakenTurn_radps = 0.1;  ///< mean over a frame's interval

/// Largest standard deviation over the three axes.
template <typename Field>
double spread(std::span<const ImuSample> imu, const Field& field) {
  double worst = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double sum = 0, squares = 0;
    for (const ImuSample& s : imu) sum += field(s)[axis];
    const double mean = sum / static_cast<double>(imu.size());
    for (const ImuSample& s : imu) squares += (field(s)[axis] - mean) * (field(s)[axis] - mean);
    worst = std::max(worst, std::sqrt(squares / static_cast<double>(imu.size())));
  }
  return worst;
}

/// By how much the rig is turned at the end of the interval against its mean attitude over the
/// interval: what a motor's vibration has just done to the picture. Radians, body frame.
Eigen::Vector3d shake(std::span<const ImuSample> imu, const Eigen::Vector3d& bias_radps) {
  Eigen::Vector3d angle = Eigen::Vector3d::Zero(), sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 1; i < imu.size(); ++i) {
    const Eigen::Map<const Eigen::Vector3d> before(imu[i - 1].gyro_radps.data());
    const Eigen::Map<const Eigen::Vector3d> gyro(imu[i].gyro_radps.data());
    const double dt_s = (imu[i].t - imu[i - 1].t).seconds();
    const Eigen::Vector3d step = (0.5 * (before + gyro) - bias_radps) * dt_s;
    sum += (angle + 0.5 * step) * dt_s;
    angle += step;
  }
  return angle - sum / (imu.back().t - imu.front().t).seconds();
}

double middle_of(std::span<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

StillDetector::StillDetector(const RigCalibration& rig) noexcept
    : focal_px_(mean_focal_px(rig.cameras[rig.frame_camera])),
      q_bc_(rig.cameras[rig.frame_camera].T_body_cam.q),
      gyro_std_radps_(3.0 * rig.imu.gyro_density * std::sqrt(rig.imu.rate_hz) + kGyroMargin_radps),
      accel_std_mps2_(3.0 * rig.imu.accel_density * std::sqrt(rig.imu.rate_hz) +
                      kAccelMargin_mps2) {}

bool StillDetector::quiet(std::span<const ImuSample> imu, const NavState& predicted) noexcept {
  if (imu.size() < 3) return false;
  shaken_rad_ = shake(imu, predicted.bg);
  const double gyro = spread(imu, [](const ImuSample& s) { return s.gyro_radps; });
  const double accel = spread(imu, [](const ImuSample& s) { return s.accel_mps2; });
  if (gyro < gyro_std_radps_ && accel < accel_std_mps2_) return true;
  Eigen::Vector3d turn_radps = -predicted.bg;
  for (const ImuSample& s : imu)
    turn_radps +=
        Eigen::Map<const Eigen::Vector3d>(s.gyro_radps.data()) / static_cast<double>(imu.size());
  return gyro < kGyroShake_radps && accel < kAccelShake_mps2 &&
         turn_radps.norm() < kShakenTurn_radps && predicted.v_wb.norm() < kShakenSpeed_mps;
}

/// Compares each point's place with the one where it was first seen in this standstill. Points that
/// are gone are forgotten and new ones take their place, so that a reference never wears out.
bool StillDetector::in_place(const FrameMeasurement& frame, std::size_t& common) noexcept {
  std::size_t stay = 0, kept = 0;
  common = 0;
  last_reference_ = reference_;
  const std::span<const Place> known(last_reference_.data(), num_reference_);
  for (const PointMeasurement& point : frame.points) {
    const auto found = std::ranges::find(known, point.id, &Place::id);
    if (found == known.end()) {
      reference_[kept++] = {point.id, point.bearing_xy, frame.t, shaken_rad_};
      continue;
    }
    reference_[kept++] = *found;
    if (frame.t - found->since < kLeastAge) continue;
    // Motors shake the rig by more than points are exact; the gyro knows by how much.
    const Eigen::Vector3d turned_c = q_bc_.conjugate() * (shaken_rad_ - found->shaken_rad);
    const Eigen::Vector3d seen(point.bearing_xy[0], point.bearing_xy[1], 1.0);
    const Eigen::Vector3d now = seen + turned_c.cross(seen);
    if (!(now.z() > 0)) continue;
    const double dx = (now.x() / now.z() - found->xy[0]) * focal_px_;
    const double dy = (now.y() / now.z() - found->xy[1]) * focal_px_;
    if (std::hypot(dx, dy) < kPlace_px) ++stay;
    // The third: away from the centre, as a motion along the axis shifts them.
    const double r = std::hypot(found->xy[0], found->xy[1]) + 1e-9;
    shifts_px_[0][common] = dx;
    shifts_px_[1][common] = dy;
    shifts_px_[2][common++] = (dx * found->xy[0] + dy * found->xy[1]) / r;
  }
  num_reference_ = kept;
  if (common < kMinCommon) return frame.t - since_ < kMinStill;
  if (static_cast<double>(stay) < kShare * static_cast<double>(common)) return false;
  const double together_px =
      kTogether_px + kTogetherNoise_px / std::sqrt(static_cast<double>(common));
  return std::ranges::all_of(shifts_px_, [&](auto& shifts) {
    return std::abs(middle_of({shifts.data(), common})) < together_px;
  });
}

void StillDetector::set_reference(const FrameMeasurement& frame) noexcept {
  num_reference_ = 0;
  for (const PointMeasurement& point : frame.points)
    reference_[num_reference_++] = {point.id, point.bearing_xy, frame.t, shaken_rad_};
}

void StillDetector::reset() noexcept {
  num_reference_ = 0;
  still_ = false;
  wait_ = kMinStill;
}

void StillDetector::begin(const FrameMeasurement& frame, std::span<const ImuSample> imu,
                          const NavState& state, Timestamp since) noexcept {
  reset();
  if (!imu.empty()) shaken_rad_ = shake(imu, state.bg);
  set_reference(frame);
  for (std::size_t i = 0; i < num_reference_; ++i) reference_[i].since = since;
  since_ = since;
}

bool StillDetector::update(const FrameMeasurement& frame, std::span<const ImuSample> imu,
                           const NavState& predicted) noexcept {
  if (!quiet(imu, predicted)) {
    still_ = false;
    num_reference_ = 0;
    return false;
  }
  std::size_t common = 0;
  if (num_reference_ == 0 || !in_place(frame, common)) {
    wait_ = num_reference_ == 0 ? kMinStill : kMinStillAgain;
    still_ = false;
    since_ = frame.t;
    set_reference(frame);
    return false;
  }
  still_ = frame.t - since_ >= wait_ && common >= kMinCommon;
  return still_;
}

}  // namespace pled
