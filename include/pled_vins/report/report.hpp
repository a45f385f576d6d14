#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pled::report {

inline constexpr const char* kReportFileName = "report.html";
inline constexpr const char* kComparisonFileName = "comparison.html";
/// What a page may weigh. Pictures are scaled down to fit.
inline constexpr std::uintmax_t kMaxPageBytes = 3'000'000;

struct Options {
  std::string recording;  ///< empty: the folder that report.json names
  std::string out;        ///< empty: report.html or comparison.html in the (second) folder
};

/// What became of a page.
struct Outcome {
  std::filesystem::path file;
  std::uintmax_t bytes = 0;
  std::string error;               ///< empty when the page was written
  std::vector<std::string> notes;  ///< what is missing in it, and why
};

/// Makes one self-contained HTML page about the results of a replay. A recording that
/// is gone costs the pictures, the truth and the sensor rates; features.csv the
/// weights: a note says so. Errors: no report.json or trajectory.tum, and any file
/// that does not read, with its line.
[[nodiscard]] Outcome write_report(const std::filesystem::path& folder, const Options& options);

/// The same page with two runs side by side, and what differs in their settings.
[[nodiscard]] Outcome write_comparison(const std::filesystem::path& a,
                                       const std::filesystem::path& b, const Options& options);

}  // namespace pled::report
