#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include <nlohmann/json.hpp>

namespace pled::apps {

/// The number as `format` prints it, or null when it is absent or not finite.
[[nodiscard]] inline nlohmann::ordered_json json_rounded(const std::optional<double>& value,
                                                         const char* format) {
  if (!value || !std::isfinite(*value)) return nullptr;
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), format, *value);
  return std::strtod(text.data(), nullptr);
}

/// A figure, to nine digits: more are noise of the arithmetic (3.0999999999999996).
[[nodiscard]] inline nlohmann::ordered_json json_number(const std::optional<double>& value) {
  return json_rounded(value, "%.9g");
}

/// A time or a span, s: to the nanosecond, or the microsecond where a double of an epoch
/// holds no more.
[[nodiscard]] inline nlohmann::ordered_json json_seconds(const std::optional<double>& value) {
  constexpr double kFine_s = 1e6;
  return json_rounded(value, value && std::abs(*value) < kFine_s ? "%.9f" : "%.6f");
}

}  // namespace pled::apps
