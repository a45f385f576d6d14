#pragma once

#include <string>

namespace pled {

/// Why a settings or calibration file was refused, in words for its author.
struct ConfigError {
  std::string file;
  int line = 0;      ///< from 1; 0 when the fault has no line (a missing file)
  std::string key;   ///< dotted, as in `backend.max_iterations`; may be empty
  std::string text;  ///< what is wrong and, where known, what would be right

  /// "FILE:LINE: KEY: TEXT", leaving out what is unknown.
  [[nodiscard]] std::string message() const;
};

}  // namespace pled
