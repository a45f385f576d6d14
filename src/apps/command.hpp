#pragma once

#include <memory>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace pled::apps {

/// What the process tells its caller.
enum class ExitCode : int { kDone = 0, kFailed = 1, kMisused = 2 };

/// One subcommand: declares its options, then runs with what was parsed into its
/// members. Results go to stdout, words about them to stderr.
class Command {
 public:
  Command() = default;
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;
  virtual ~Command() = default;

  [[nodiscard]] virtual std::string_view name() const noexcept = 0;
  [[nodiscard]] virtual std::string_view summary() const noexcept = 0;
  /// Lines for the end of the help, without a heading.
  [[nodiscard]] virtual std::string_view examples() const noexcept = 0;
  virtual void declare(CLI::App& app) = 0;
  /// Called once after a successful parse. A failure has printed why to stderr.
  [[nodiscard]] virtual ExitCode run() = 0;
};

/// Every subcommand, in the order of the help.
[[nodiscard]] std::vector<std::unique_ptr<Command>> all_commands();

}  // namespace pled::apps
