#pragma once

#include "src/apps/command.hpp"

namespace pled::apps {

/// Parses the command line, runs the subcommand and flushes stdout. Catches every
/// exception; a misused command line says what is wrong, what was likely meant, and
/// where the help is.
[[nodiscard]] ExitCode run(int argc, const char* const* argv) noexcept;

}  // namespace pled::apps
