#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "src/apps/commands.hpp"
#include "src/apps/replay_session.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

class ReplayCommand final : public Command {
 public:
  std::string_view name() const noexcept override { return "replay"; }
  std::string_view summary() const noexcept override {
    return "Estimate the trajectory of a recording";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins replay recording --out results\n"
           "  pled-vins replay mav0 --out results --config my.yaml --force\n"
           "  pled-vins replay recording --out results --start 2.5 --duration 10";
  }

  void declare(CLI::App& app) override {
    app.add_option("RECORDING", options_.recording,
                   "Folder in the RPG DAVIS layout, or a EuRoC mav0 folder")
        ->required();
    app.add_option("--out", options_.out, "Folder for trajectory.tum, features.csv, report.json")
        ->required();
    app.add_flag("--force", options_.force, "Overwrite results that are there");
    app.add_option("--config", options_.config, "Settings file (YAML); default: built-in settings");
    app.add_option("--start", options_.start_s, "Begin this many seconds after the first frame")
        ->check(CLI::NonNegativeNumber)
        ->default_val(0.0);
    app.add_option("--duration", options_.duration_s, "Play at most this many seconds")
        ->check(CLI::PositiveNumber);
  }

  ExitCode run() override { return run_replay(options_) ? ExitCode::kDone : ExitCode::kFailed; }

 private:
  ReplayOptions options_;
};

}  // namespace

std::unique_ptr<Command> make_replay_command() { return std::make_unique<ReplayCommand>(); }

}  // namespace pled::apps
