#pragma once

#include <string>
#include <vector>

#include "drivers/replay/recording.hpp"
#include "src/report/feature_digest.hpp"
#include "src/report/json.hpp"
#include "src/report/rates.hpp"

namespace pled::report {

/// The moments with their pictures: frame, events of the 30 ms before it, labels.
/// Without a recording the features alone. `picture_bytes` bounds what all pictures
/// together add to the page; `event_rates` is filled on the way, so that the events
/// are read once.
[[nodiscard]] Json make_moments(const std::vector<Moment>& moments,
                                const replay::Recording* recording, PlayedSpan span,
                                std::size_t picture_bytes, Json& event_rates,
                                std::vector<std::string>& notes);

}  // namespace pled::report
