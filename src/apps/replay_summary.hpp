#pragma once

#include <cstdint>
#include <optional>

#include "drivers/replay/recording.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/evaluation/evaluate.hpp"
#include "pled_vins/pipeline/inline_runner.hpp"
#include "src/apps/estimator_storage.hpp"
#include "src/apps/replay_meters.hpp"
#include "src/apps/replay_output.hpp"
#include "src/apps/replay_session.hpp"

namespace pled::apps {

/// Everything that is known when a replay has ended.
struct ReplayFacts {
  const ReplayOptions& options;
  const replay::Recording& recording;
  const std::optional<FrameSpan>& observations;  ///< of the whole recording
  const limits::SensorClass& sensor;
  const EstimatorParts& parts;
  const RunEnd& end;
  const ReplayMeters& meters;
  const replay::FrameFaults& frame_faults;
};

/// Closes the result files, compares with the truth where there is one, writes
/// report.json and prints the summary. False when a file could not be written or a
/// stream broke.
[[nodiscard]] bool finish_replay(const ReplayFacts& facts, ReplayOutput& output);

}  // namespace pled::apps
