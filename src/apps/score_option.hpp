#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "pled_vins/config/nearest.hpp"
#include "pled_vins/config/schema.hpp"

namespace pled::apps {

/// --score motion|paper|count
inline void add_score_option(CLI::App& app, std::optional<TemporalScore>& score) {
  const auto take = [&score](const std::string& word) {
    std::vector<std::string_view> names;
    for (const auto& [value, name] : kTemporalScoreNames) {
      if (CLI::detail::to_lower(word) == name) score = value;
      names.push_back(name);
    }
    if (!score)
      throw CLI::ValidationError("--score", "there is no score '" + word + "', did you mean '" +
                                                std::string(nearest(word, names)) + "'?");
  };
  app.add_option_function<std::string>(
         "--score", take,
         "What tells moving points before the solve: motion (tracks against the camera's motion), "
         "paper (entropy-recency), count (of events)")
      ->type_name("NAME");
}

}  // namespace pled::apps
