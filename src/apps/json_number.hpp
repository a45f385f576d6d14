#pragma once

#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

namespace pled::apps {

/// The number, or null when it is absent or not finite.
[[nodiscard]] inline nlohmann::ordered_json json_number(const std::optional<double>& value) {
  if (!value || !std::isfinite(*value)) return nullptr;
  return *value;
}

}  // namespace pled::apps
