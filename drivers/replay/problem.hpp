#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace pled::replay {

enum class Severity : std::uint8_t {
  kWarning,  ///< data are missing or odd; work goes on
  kError,    ///< this cannot be done
};

/// One thing that is wrong with a recording, in words for people: what, where, how to fix it.
struct Problem {
  Severity severity = Severity::kError;
  std::string file;       ///< empty: the recording as a whole
  std::int64_t line = 0;  ///< from 1; 0: not one line
  std::string text;
};

using Problems = std::vector<Problem>;

/// "error: /rec/imu.txt:12: text".
[[nodiscard]] std::string to_string(const Problem& problem);

}  // namespace pled::replay
