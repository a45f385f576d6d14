#include <string>

#include <CLI/CLI.hpp>

#include "src/apps/commands.hpp"
#include "src/apps/replay_session.hpp"

namespace pled::apps {
namespace {

/// A number of seconds that a recording can have; CLI11's own ranges let NaN pass.
CLI::Validator seconds(bool may_be_zero) {
  constexpr double kLongest_s = 1e6;
  const auto check = [may_be_zero](const std::string& word) -> std::string {
    double value_s = 0.0;
    const bool is_number = CLI::detail::lexical_cast(word, value_s);
    if (is_number && value_s <= kLongest_s && (value_s > 0.0 || (may_be_zero && value_s == 0.0)))
      return {};
    return std::string("must be a number of seconds ") + (may_be_zero ? ">= 0" : "> 0") +
           " and <= 1000000, not '" + word + "'";
  };
  return {check, ""};
}

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
        ->type_name("S")
        ->check(seconds(true))
        ->default_val(0.0);
    app.add_option("--duration", options_.duration_s,
                   "Play at most this many seconds; default: all")
        ->type_name("S")
        ->check(seconds(false));
  }

  ExitCode run() override { return run_replay(options_) ? ExitCode::kDone : ExitCode::kFailed; }

 private:
  ReplayOptions options_;
};

}  // namespace

std::unique_ptr<Command> make_replay_command() { return std::make_unique<ReplayCommand>(); }

}  // namespace pled::apps
