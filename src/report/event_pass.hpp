#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "drivers/replay/recording.hpp"
#include "pled_vins/core/messages.hpp"

namespace pled::report {

/// Hands every event of the recording to `visit`, in order, until it says false.
/// Returns why reading ended before the end, empty when it did not.
[[nodiscard]] std::string visit_events(const replay::Recording& recording,
                                       const std::function<bool(std::span<const Event>)>& visit);

}  // namespace pled::report
