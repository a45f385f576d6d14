#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "src/report/json.hpp"

namespace pled::report {

/// Everything that the page shows of one run.
struct RunData {
  Json data;
  std::string error;               ///< empty when `data` is whole
  std::vector<std::string> notes;  ///< what is missing, also in `data`
};

/// Collects it from a results folder and from the recording that report.json names, or
/// from `recording` where that is not empty. `picture_bytes` bounds the pictures.
[[nodiscard]] RunData load_run(const std::filesystem::path& folder, const std::string& recording,
                               std::size_t picture_bytes);

}  // namespace pled::report
