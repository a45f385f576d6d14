#pragma once

#include "pled_vins/pipeline/health.hpp"
#include "pled_vins/pipeline/inline_runner.hpp"
#include "src/apps/opened_recording.hpp"

namespace pled::apps {

/// After a run, notes of what its counts cannot say: where the last fault of each stream was, and
/// that events were there but none came.
void tell_stream_faults(const OpenedRecording& opened, const Health& health);

/// Says which streams broke before their end. False when one did.
[[nodiscard]] bool tell_failures(const RunEnd& end);

}  // namespace pled::apps
