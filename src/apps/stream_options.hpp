#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "src/apps/opened_recording.hpp"

namespace pled::apps {

/// --no-frames and --no-events, of which a run may have one.
inline void add_stream_options(CLI::App& app, PlayOptions& play) {
  app.add_flag_callback(
      "--no-frames", [&play] { play.use_frames = false; },
      "See by events alone; frames give only the times (20 Hz without any)");
  app.add_flag_callback(
      "--no-events", [&play] { play.use_events = false; }, "See by frames alone");
  app.parse_complete_callback([&play] {
    if (!play.use_frames && !play.use_events)
      throw CLI::ValidationError("--no-frames and --no-events together leave nothing to see by");
  });
}

}  // namespace pled::apps
