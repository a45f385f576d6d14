#include "src/apps/problems.hpp"

#include <cstdio>

namespace pled::apps {

bool print_problems(const replay::Problems& problems) {
  bool error = false;
  for (const replay::Problem& problem : problems) {
    error = error || problem.severity == replay::Severity::kError;
    std::fprintf(stderr, "pled-vins: %s\n", replay::to_string(problem).c_str());
  }
  return error;
}

}  // namespace pled::apps
