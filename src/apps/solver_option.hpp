#pragma once

#include <map>
#include <string>

#include <CLI/CLI.hpp>

#include "src/apps/opened_recording.hpp"

namespace pled::apps {

/// --solver fixed|ceres.
inline void add_solver_option(CLI::App& app, PlayOptions& play) {
  static const std::map<std::string, SolverKind> kNames{{"fixed", SolverKind::kFixed},
                                                        {"ceres", SolverKind::kCeres}};
  app.add_option("--solver", play.solver,
                 "What solves the window: fixed (default) or ceres, the reference")
      ->transform(CLI::CheckedTransformer(kNames).description("fixed|ceres"))
      ->option_text("NAME");
}

}  // namespace pled::apps
