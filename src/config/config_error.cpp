#include "pled_vins/config/config_error.hpp"

namespace pled {

std::string ConfigError::message() const {
  std::string out = file;
  if (line > 0) out.append(":").append(std::to_string(line));
  for (const std::string* part : {&key, &text}) {
    if (part->empty()) continue;
    if (!out.empty()) out += ": ";
    out += *part;
  }
  return out;
}

}  // namespace pled
