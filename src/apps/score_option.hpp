#pragma once

#include <map>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "pled_vins/config/schema.hpp"

namespace pled::apps {

/// --score motion|paper|count
inline void add_score_option(CLI::App& app, std::optional<TemporalScore>& score) {
  std::map<std::string, TemporalScore> names;
  for (const auto& [value, name] : kTemporalScoreNames) names.emplace(name, value);
  app.add_option("--score", score,
                 "What tells moving points before the solve: motion (tracks against the camera's "
                 "motion), paper (entropy-recency), count (of events)")
      ->type_name("NAME")
      ->transform(CLI::CheckedTransformer(names, CLI::ignore_case));
}

}  // namespace pled::apps
