#include <cstdio>
#include <string>

#include <CLI/CLI.hpp>

#include "pled_vins/report/report.hpp"
#include "src/apps/commands.hpp"
#include "src/apps/replay_session.hpp"
#include "src/apps/score_option.hpp"
#include "src/apps/solver_option.hpp"
#include "src/apps/stream_options.hpp"
#include "src/apps/text.hpp"

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
           "  pled-vins replay recording --out results --start 2.5 --duration 10\n"
           "  pled-vins replay recording --out results --no-frames";
  }

  void declare(CLI::App& app) override {
    app.add_option("RECORDING", options_.play.recording,
                   "Folder in the RPG DAVIS layout, a EuRoC mav0 folder, or an AEDAT file")
        ->required();
    app.add_option("--out", options_.out,
                   "Folder for trajectory.tum, features.csv, report.json, config.yaml, report.html")
        ->required();
    app.add_flag("--force", options_.force, "Overwrite results that are there");
    app.add_option("--config", options_.play.config,
                   "Settings file (YAML); default: built-in settings");
    app.add_option("--start", options_.play.start_s,
                   "Begin this many seconds after the first frame")
        ->type_name("S")
        ->check(seconds(true))
        ->default_val(0.0);
    app.add_option("--duration", options_.play.duration_s,
                   "Play at most this many seconds; default: all")
        ->type_name("S")
        ->check(seconds(false));
    add_stream_options(app, options_.play);
    add_solver_option(app, options_.play);
    add_score_option(app, options_.play.score);
    app.add_flag("--no-report", no_report_, "Do not make report.html");
  }

  ExitCode run() override {
    if (!run_replay(options_)) return ExitCode::kFailed;
    if (!no_report_) make_page();
    return ExitCode::kDone;
  }

 private:
  /// The results are good whether or not there is a page about them.
  void make_page() const {
    const report::Outcome page = report::write_report(options_.out, {});
    for (const std::string& note : page.notes) print_note(note);
    if (page.error.empty())
      std::printf("%-15s %s\n", "report", page.file.c_str());
    else
      print_warning("no report was made: " + page.error);
  }

  ReplayOptions options_;
  bool no_report_ = false;
};

}  // namespace

std::unique_ptr<Command> make_replay_command() { return std::make_unique<ReplayCommand>(); }

}  // namespace pled::apps
