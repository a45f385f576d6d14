#pragma once

#include <compare>
#include <cstdint>

namespace pled {

/// A span of time in integer microseconds.
struct Duration {
  std::int64_t us = 0;

  [[nodiscard]] static constexpr Duration from_ms(std::int64_t ms) noexcept { return {ms * 1000}; }
  /// Rounds to the nearest microsecond. A span beyond +-kMax_s is held there, so that an
  /// instant can still be moved by it; NaN is no span at all.
  [[nodiscard]] static constexpr Duration from_s(double s) noexcept {
    if (!(s == s)) return {};  // std::isnan is not constexpr
    const double held_s = s < -kMax_s ? -kMax_s : (s > kMax_s ? kMax_s : s);
    return {static_cast<std::int64_t>(held_s * 1e6 + (s < 0 ? -0.5 : 0.5))};
  }
  static constexpr double kMax_s = 4e12;  ///< 127 000 years, less than half of what `us` holds
  [[nodiscard]] constexpr double seconds() const noexcept { return static_cast<double>(us) * 1e-6; }
  constexpr auto operator<=>(const Duration&) const noexcept = default;
};

/// An instant on the estimator clock (the IMU's), integer microseconds since an
/// epoch that the recording or device chooses. Devices' own clocks and their
/// wrap-around end in the driver.
struct Timestamp {
  std::int64_t us = 0;

  [[nodiscard]] constexpr double seconds() const noexcept { return static_cast<double>(us) * 1e-6; }
  constexpr auto operator<=>(const Timestamp&) const noexcept = default;
};

[[nodiscard]] constexpr Duration operator-(Timestamp a, Timestamp b) noexcept {
  return {a.us - b.us};
}
[[nodiscard]] constexpr Timestamp operator+(Timestamp t, Duration d) noexcept {
  return {t.us + d.us};
}
[[nodiscard]] constexpr Timestamp operator-(Timestamp t, Duration d) noexcept {
  return {t.us - d.us};
}
[[nodiscard]] constexpr Duration operator+(Duration a, Duration b) noexcept {
  return {a.us + b.us};
}
[[nodiscard]] constexpr Duration operator-(Duration a, Duration b) noexcept {
  return {a.us - b.us};
}
[[nodiscard]] constexpr Duration operator-(Duration a) noexcept { return {-a.us}; }

}  // namespace pled
