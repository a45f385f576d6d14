#pragma once

#include <string>

#include "src/apps/opened_recording.hpp"

namespace pled::apps {

struct ReplayOptions {
  PlayOptions play;
  std::string out;
  bool force = false;
};

/// Replays a recording into the output folder. Prints a summary to stdout and what
/// went wrong to stderr; false when it failed.
[[nodiscard]] bool run_replay(const ReplayOptions& options);

}  // namespace pled::apps
