#pragma once

#include <cmath>
#include <span>

#include <nlohmann/json.hpp>

namespace pled::report {

using Json = nlohmann::ordered_json;

/// The number with so many decimals, which makes its text short; null when it is not finite.
[[nodiscard]] inline Json rounded(double value, int decimals) {
  if (!std::isfinite(value)) return nullptr;
  const double scale = std::pow(10.0, decimals);
  return std::round(value * scale) / scale;
}

/// Seconds from `zero_ns` to `stamp_ns`, to the microsecond.
[[nodiscard]] inline Json since_s(std::int64_t stamp_ns, std::int64_t zero_ns) {
  return rounded(static_cast<double>(stamp_ns - zero_ns) * 1e-9, 6);
}

}  // namespace pled::report
