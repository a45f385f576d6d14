#pragma once

#include "drivers/replay/problem.hpp"

namespace pled::apps {

/// Prints each on a line of its own on stderr; true when one of them is an error.
bool print_problems(const replay::Problems& problems);

}  // namespace pled::apps
