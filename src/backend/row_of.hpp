#pragma once

#include <cstddef>

#include "pled_vins/backend/window.hpp"

namespace pled {

/// First row of a state in the window's equations.
[[nodiscard]] constexpr int row_of(std::size_t state) noexcept {
  return static_cast<int>(state) * kStateDim;
}

}  // namespace pled
