#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/decode/aedat2_records.hpp"
#include "pled_vins/core/messages.hpp"

namespace pled {

/// What one step of the inertial words stands for.
struct Aedat2ImuScale {
  double accel_g = 1.0 / 4096.0;   ///< +-8 g over 16 bits
  double gyro_degps = 1.0 / 32.8;  ///< +-1000 deg/s, as the data sheet of the MPU-6150 has it
};

/// Collects the seven words ax ay az temperature gx gy gz to samples in m/s^2 (g taken as
/// 9.80665) and rad/s. The axes are those of the chip, no sign is changed; the stamp is that
/// of the first word.
class Aedat2ImuCollector {
 public:
  explicit Aedat2ImuCollector(Aedat2ImuScale scale) noexcept : scale_(scale) {}

  /// A sample when `record` is the last word of one. Other kinds of records may lie between.
  [[nodiscard]] std::optional<ImuSample> take(const Aedat2Record& record) noexcept;
  /// No record follows.
  void finish() noexcept;
  /// Groups that lack a word, and words without a group.
  [[nodiscard]] std::uint64_t malformed() const noexcept { return malformed_; }

 private:
  static constexpr unsigned kWords = 7;

  Aedat2ImuScale scale_;
  std::array<std::int16_t, kWords> words_{};
  unsigned count_ = 0;
  std::int64_t t_us_ = 0;
  std::uint64_t malformed_ = 0;
};

}  // namespace pled
