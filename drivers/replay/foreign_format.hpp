#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace pled::replay {

/// What a file that begins so is, when it is known to hold no events that are read here:
/// "a PNG image", "a ROS bag". Empty when it may be an event file.
[[nodiscard]] std::string_view foreign_format(std::span<const std::byte> head) noexcept;

}  // namespace pled::replay
