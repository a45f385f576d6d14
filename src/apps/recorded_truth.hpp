#pragma once

#include <optional>

#include "drivers/replay/recording.hpp"
#include "pled_vins/evaluation/evaluate.hpp"
#include "pled_vins/pipeline/inline_runner.hpp"

namespace pled::apps {

/// The truth of a recording, passing over lines that cannot be read, with a note of them. Empty
/// when there is none.
[[nodiscard]] Trajectory read_truth(const replay::Recording& recording);

/// The observations that a run played, for the coverage: its first and last, with the period of
/// the whole recording. nullopt when nothing was played.
[[nodiscard]] std::optional<FrameSpan> played_frames(const std::optional<FrameSpan>& whole,
                                                     const RunEnd& end);

}  // namespace pled::apps
