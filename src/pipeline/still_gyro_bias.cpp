#include "pled_vins/pipeline/still_gyro_bias.hpp"

#include <algorithm>

namespace pled {
namespace {

// Half the noise of a tracked point over one interval: less is rest.
constexpr double kStillFlowPx = 0.3;
constexpr std::size_t kFewestPoints = 15;
// Readings above this are motion, whatever the picture says (a dark or frozen image).
constexpr double kLargestBiasRadps = 0.3;
constexpr std::uint32_t kLongestMean = 40;

}  // namespace

void StillGyroBias::observe(const ImuHistory& imu, Timestamp from, Timestamp to,
                            double median_flow_px, std::size_t points) noexcept {
  if (points < kFewestPoints || !(median_flow_px < kStillFlowPx)) return;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (std::size_t i = imu.size(); i-- > 0 && imu[i].t > from;) {
    if (imu[i].t > to) continue;
    sum += Eigen::Map<const Eigen::Vector3d>(imu[i].gyro_radps.data());
    count += 1.0;
  }
  if (!(count > 0.0)) return;
  const Eigen::Vector3d mean = sum / count;
  if (!(mean.norm() < kLargestBiasRadps)) return;
  intervals_ = std::min(intervals_ + 1, kLongestMean);
  bias_ += (mean - bias_) / static_cast<double>(intervals_);
}

}  // namespace pled
