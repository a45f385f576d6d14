#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>

#include "pled_vins/sim/simulator.hpp"
#include "src/apps/commands.hpp"
#include "src/apps/progress.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

namespace fs = std::filesystem;

class SimulateCommand final : public Command {
 public:
  std::string_view name() const noexcept override { return "simulate"; }
  std::string_view summary() const noexcept override {
    return "Make a recording: a flight through a room, with frames, events, IMU and truth";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins simulate --out demo\n"
           "  pled-vins simulate --out busy --seed 7 --duration 5 --moving high\n"
           "  pled-vins simulate --out still --preset still --force";
  }

  void declare(CLI::App& app) override {
    app.add_option("--out", out_, "Folder to write")->required();
    app.add_option("--preset", preset_, "Ready-made options")
        ->check(CLI::IsMember({"demo", "test", "hall", "still"}))
        ->capture_default_str();
    app.add_option("--seed", seed_, "Same seed, same bytes")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    app.add_option("--duration", duration_s_, "Length, s (default: the preset's)");
    app.add_option("--moving", moving_, "How much moves by itself (default: the preset's)")
        ->check(CLI::IsMember({"none", "low", "high"}));
    app.add_flag("--force", force_, "Replace a recording that is there");
  }

  ExitCode run() override {
    std::optional<sim::SimulationOptions> options = sim::preset(preset_);
    if (!options) return misused("unknown preset " + preset_);
    options->seed = seed_;
    if (duration_s_) options->duration_s = *duration_s_;
    if (moving_ == "none") options->moving = sim::MovingLevel::kNone;
    if (moving_ == "low") options->moving = sim::MovingLevel::kLow;
    if (moving_ == "high") options->moving = sim::MovingLevel::kHigh;
    const ConfigIssue issue = sim::check(*options);
    if (issue.key != nullptr) return misused(std::string(issue.key) + " " + issue.rule);

    std::error_code ignored;  // a folder that cannot be read is found out when writing
    if (!force_ && fs::exists(out_, ignored) && !fs::is_empty(out_, ignored)) {
      print_error(out_ + " is there and not empty; --force replaces the recording in it");
      return ExitCode::kFailed;
    }
    return write(*options);
  }

 private:
  static ExitCode misused(const std::string& text) {
    print_error(text);
    return ExitCode::kMisused;
  }

  ExitCode write(const sim::SimulationOptions& options) const {
    Progress progress = Progress::on_stderr(options.duration_s);
    const Result<sim::SimulationSummary> result = sim::simulate(
        options, out_, [&](double share) { progress.update(share * options.duration_s); });
    if (!result.ok()) {
      print_error("cannot write the recording to " + out_ + ": " +
                  std::string(to_string(result.error().code)));
      return ExitCode::kFailed;
    }
    progress.finish();
    const sim::SimulationSummary& s = result.value();
    std::printf("%-10s %s\n%-10s %.3f s, %.2f m\n", "recording", out_.c_str(), "flight",
                s.duration_s, s.path_m);
    std::printf("%-10s %llu\n%-10s %llu\n%-10s %llu\n", "frames",
                static_cast<unsigned long long>(s.frames), "imu",
                static_cast<unsigned long long>(s.imu_samples), "events",
                static_cast<unsigned long long>(s.events));
    return ExitCode::kDone;
  }

  std::string out_;
  std::string preset_ = "demo";
  std::string moving_;
  std::uint64_t seed_ = 1;
  std::optional<double> duration_s_;
  bool force_ = false;
};

}  // namespace

std::unique_ptr<Command> make_simulate_command() { return std::make_unique<SimulateCommand>(); }

}  // namespace pled::apps
