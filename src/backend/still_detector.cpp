#include "pled_vins/backend/still_detector.hpp"

#include <cmath>

namespace pled {
namespace {

constexpr double kPlace_px = 0.8;  ///< a point within this distance has not moved
constexpr double kShare = 0.6;     ///< of points that must not have moved
constexpr std::size_t kMinCommon = 10;
constexpr double kGyroMargin_radps = 0.01;  ///< vibration on top of the sensor's noise
constexpr double kAccelMargin_mps2 = 0.06;

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

}  // namespace

StillDetector::StillDetector(const RigCalibration& rig) noexcept
    : focal_px_(mean_focal_px(rig.cameras[rig.frame_camera])),
      gyro_std_radps_(3.0 * rig.imu.gyro_density * std::sqrt(rig.imu.rate_hz) + kGyroMargin_radps),
      accel_std_mps2_(3.0 * rig.imu.accel_density * std::sqrt(rig.imu.rate_hz) +
                      kAccelMargin_mps2) {}

bool StillDetector::quiet(std::span<const ImuSample> imu) const noexcept {
  if (imu.size() < 3) return false;
  const double gyro = spread(imu, [](const ImuSample& s) { return s.gyro_radps; });
  const double accel = spread(imu, [](const ImuSample& s) { return s.accel_mps2; });
  return gyro < gyro_std_radps_ && accel < accel_std_mps2_;
}

bool StillDetector::in_place(const FrameMeasurement& frame, std::size_t& common) const noexcept {
  std::size_t stay = 0;
  common = 0;
  for (const PointMeasurement& point : frame.points) {
    for (std::size_t k = 0; k < num_reference_; ++k) {
      if (reference_[k].id != point.id) continue;
      ++common;
      const double dx = point.bearing_xy[0] - reference_[k].xy[0];
      const double dy = point.bearing_xy[1] - reference_[k].xy[1];
      if (std::sqrt(dx * dx + dy * dy) * focal_px_ < kPlace_px) ++stay;
      break;
    }
  }
  return static_cast<double>(stay) >= kShare * static_cast<double>(common) && common > 0;
}

void StillDetector::set_reference(const FrameMeasurement& frame) noexcept {
  num_reference_ = 0;
  for (const PointMeasurement& point : frame.points)
    reference_[num_reference_++] = {point.id, point.bearing_xy};
}

bool StillDetector::update(const FrameMeasurement& frame, std::span<const ImuSample> imu) noexcept {
  if (!quiet(imu)) {
    still_ = false;
    num_reference_ = 0;
    return false;
  }
  std::size_t common = 0;
  if (num_reference_ == 0 || !in_place(frame, common)) {
    still_ = false;
    since_ = frame.t;
    set_reference(frame);
    return false;
  }
  still_ = frame.t - since_ >= kMinStill && common >= kMinCommon;
  // Tracks end even in front of a parked robot: a fresh reference once most have.
  if (still_ && common < 3 * kMinCommon) set_reference(frame);
  return still_;
}

}  // namespace pled
