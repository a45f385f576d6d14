#include <cstdio>
#include <string>

#include <CLI/CLI.hpp>

#include "pled_vins/report/report.hpp"
#include "src/apps/commands.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

/// The page's file on stdout; what it lacks, or why there is none, on stderr.
ExitCode tell(const report::Outcome& outcome) {
  for (const std::string& note : outcome.notes) print_note(note);
  if (!outcome.error.empty()) {
    print_error(outcome.error);
    return ExitCode::kFailed;
  }
  std::printf("%s\n", outcome.file.c_str());
  return ExitCode::kDone;
}

void declare_options(CLI::App& app, report::Options& options, const char* default_file) {
  app.add_option("--recording", options.recording,
                 "Folder of the recording; default: the one that report.json names");
  app.add_option("--out", options.out, std::string("File to write; default: ") + default_file);
}

class ReportCommand final : public Command {
 public:
  std::string_view name() const noexcept override { return "report"; }
  std::string_view summary() const noexcept override {
    return "Make one HTML page about the results of a replay";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins report results\n"
           "  pled-vins report results --recording /mnt/moved/recording\n"
           "  pled-vins report results --out page.html";
  }

  void declare(CLI::App& app) override {
    app.add_option("DIR", folder_, "Results of a replay: trajectory.tum, features.csv, report.json")
        ->required();
    declare_options(app, options_, "DIR/report.html");
  }

  ExitCode run() override { return tell(report::write_report(folder_, options_)); }

 private:
  std::string folder_;
  report::Options options_;
};

class CompareCommand final : public Command {
 public:
  std::string_view name() const noexcept override { return "compare"; }
  std::string_view summary() const noexcept override {
    return "Make one HTML page with two replays side by side";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins compare results results-with-my-settings\n"
           "  pled-vins compare before after --out comparison.html";
  }

  void declare(CLI::App& app) override {
    app.add_option("DIR_A", a_, "Results of a replay")->required();
    app.add_option("DIR_B", b_, "Results of another")->required();
    declare_options(app, options_, "DIR_B/comparison.html");
  }

  ExitCode run() override { return tell(report::write_comparison(a_, b_, options_)); }

 private:
  std::string a_;
  std::string b_;
  report::Options options_;
};

}  // namespace

std::unique_ptr<Command> make_report_command() { return std::make_unique<ReportCommand>(); }

std::unique_ptr<Command> make_compare_command() { return std::make_unique<CompareCommand>(); }

}  // namespace pled::apps
