#include "drivers/decode/aedat2_imu.hpp"

#include <numbers>

namespace pled {

std::optional<ImuSample> Aedat2ImuCollector::take(const Aedat2Record& record) noexcept {
  constexpr double kStandardGravity_mps2 = 9.80665;
  constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
  constexpr std::size_t kGyro = 4;  // behind accelerations and temperature
  if (record.kind() != Aedat2Kind::kImu) return std::nullopt;
  if (record.imu_code() != count_) {
    ++malformed_;  // the group that was begun, or a word without its beginning
    count_ = 0;
    if (record.imu_code() != 0) return std::nullopt;
  }
  if (count_ == 0) t_us_ = record.t_us;
  words_[count_++] = record.imu_value();
  if (count_ < kWords) return std::nullopt;
  count_ = 0;
  ImuSample sample;
  sample.t = {t_us_};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    sample.accel_mps2[axis] = words_[axis] * scale_.accel_g * kStandardGravity_mps2;
    sample.gyro_radps[axis] = words_[kGyro + axis] * scale_.gyro_degps * kRadiansPerDegree;
  }
  return sample;
}

void Aedat2ImuCollector::finish() noexcept {
  if (count_ != 0) ++malformed_;
  count_ = 0;
}

}  // namespace pled
