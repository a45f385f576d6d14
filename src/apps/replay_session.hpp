#pragma once

#include <optional>
#include <string>

namespace pled::apps {

struct ReplayOptions {
  std::string recording;
  std::string out;
  std::string config;  ///< empty: built-in settings
  bool force = false;
  double start_s = 0.0;
  std::optional<double> duration_s;
};

/// Replays a recording into the output folder. Prints a summary to stdout and what
/// went wrong to stderr; false when it failed.
[[nodiscard]] bool run_replay(const ReplayOptions& options);

}  // namespace pled::apps
