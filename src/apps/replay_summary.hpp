#pragma once

#include <cstdint>
#include <optional>

#include "drivers/replay/recording.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/pipeline/inline_runner.hpp"
#include "src/apps/estimator_storage.hpp"
#include "src/apps/replay_output.hpp"
#include "src/apps/replay_session.hpp"

namespace pled::apps {

/// Processor time and allocations of the process between start() and stop().
class ReplayMeters {
 public:
  void start();
  void stop();
  [[nodiscard]] double cpu_s() const { return cpu_s_; }
  [[nodiscard]] std::optional<std::uint64_t> allocations() const { return allocations_; }

 private:
  double cpu_s_ = 0.0;
  std::optional<std::uint64_t> allocations_;
};

/// Everything that is known when a replay has ended.
struct ReplayFacts {
  const ReplayOptions& options;
  const replay::Recording& recording;
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
