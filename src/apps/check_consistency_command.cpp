#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <thread>

#include <CLI/CLI.hpp>

#include "src/apps/commands.hpp"
#include "src/apps/consistency_check.hpp"
#include "src/apps/progress.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

constexpr std::size_t kFramesPerLine = 10;
constexpr double kFramePeriod_s = 0.05;

class CheckConsistencyCommand final : public Command {
 public:
  CheckConsistencyCommand() {
    options_.jobs = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, 64U));
  }

  std::string_view name() const noexcept override { return "check-consistency"; }
  std::string_view summary() const noexcept override {
    return "Estimate simulated point tracks many times and compare the errors with the covariance";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins check-consistency\n"
           "  pled-vins check-consistency --runs 50 --seconds 10\n"
           "  pled-vins check-consistency --runs 100 --seconds 5 --jobs 8 --seed 1000\n"
           "Of each instant it prints the mean over the runs of e^T P^-1 e, e the error of the\n"
           "newest pose and P its covariance: 6 when P is right. Exit 0 when the mean over time\n"
           "lies within the 95 % bounds, else 1.";
  }

  void declare(CLI::App& app) override {
    app.add_option("--runs", options_.runs, "Simulated runs, each with a seed of its own")
        ->check(CLI::Range(1, 10000))
        ->capture_default_str();
    app.add_option("--seconds", options_.duration_s, "Length of a run, s")
        ->check(CLI::Range(1.0, 60.0))
        ->capture_default_str();
    app.add_option("--jobs", options_.jobs,
                   "Runs at a time; changes no figure (default: one a processor)")
        ->check(CLI::Range(1, 64));
    app.add_option("--seed", options_.first_seed, "Of the first run")->capture_default_str();
  }

  ExitCode run() override {
    Progress progress = Progress::share_on_stderr();
    const Consistency c = check_consistency(
        options_, [&](int done) { progress.update(static_cast<double>(done) / options_.runs); });
    progress.finish();
    std::printf("t_s\tnees\n");
    for (std::size_t k = 0; k < c.nees.size(); k += kFramesPerLine)
      std::printf("%.2f\t%.3f\n", kFramePeriod_s * static_cast<double>(k), c.nees[k]);
    std::printf("%-16s %d of %.1f s, %zu instants each\n", "runs", c.runs, options_.duration_s,
                c.nees.size());
    std::printf("%-16s %.3f\n", "mean_nees", c.mean);
    std::printf("%-16s %.3f to %.3f\n", "bounds_95", c.lower, c.upper);
    std::printf("%-16s %.3f\n", "share_inside", c.share_inside);
    std::printf("%-16s %s\n", "consistent", c.passed() ? "yes" : "no");
    if (c.passed()) return ExitCode::kDone;
    print_error(c.mean > c.upper
                    ? "the errors are larger than the covariance says"
                    : "the errors are smaller than the covariance says, or not a number");
    return ExitCode::kFailed;
  }

 private:
  ConsistencyOptions options_;
};

}  // namespace

std::unique_ptr<Command> make_check_consistency_command() {
  return std::make_unique<CheckConsistencyCommand>();
}

}  // namespace pled::apps
