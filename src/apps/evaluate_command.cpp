#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "pled_vins/evaluation/evaluate.hpp"
#include "src/apps/commands.hpp"
#include "src/apps/json_number.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

namespace fs = std::filesystem;

/// The file of frame stamps that belongs to a truth file: images.txt beside it, or
/// a EuRoC cam0/data.csv beside its folder. Empty when there is none.
fs::path frames_beside(const fs::path& truth) {
  const fs::path folder = truth.has_parent_path() ? truth.parent_path() : fs::path(".");
  std::error_code ignored;  // not found is an answer
  for (const fs::path& candidate :
       {folder / "images.txt", folder / "mav0/cam0/data.csv", folder / "../cam0/data.csv"})
    if (fs::is_regular_file(candidate, ignored)) return candidate;
  return {};
}

void print_figure(const char* name, const std::optional<double>& value) {
  if (value)
    std::printf("%-14s %.9g\n", name, *value);
  else
    std::printf("%-14s -\n", name);
}

void print_text(const Evaluation& e) {
  print_figure("ate_rmse_m", e.ate_rmse_m);
  print_figure("mpe_percent", e.mpe_percent);
  print_figure("rpe_trans_m", e.rpe_trans_m);
  print_figure("rpe_rot_deg", e.rpe_rot_deg);
  print_figure("coverage", e.coverage);
  std::printf("%-14s %zu of %zu (%zu outside the truth, %zu in its gaps)\n", "poses", e.matched,
              e.poses, e.outside_truth, e.in_truth_gap);
  print_figure("path_m", e.path_m);
  print_figure("span_s", e.span_s);
}

void print_json(const Evaluation& e) {
  nlohmann::ordered_json out;
  out["ate_rmse_m"] = json_number(e.ate_rmse_m);
  out["mpe_percent"] = json_number(e.mpe_percent);
  out["rpe_trans_m"] = json_number(e.rpe_trans_m);
  out["rpe_rot_deg"] = json_number(e.rpe_rot_deg);
  out["coverage"] = json_number(e.coverage);
  out["poses"] = {{"in", e.poses},
                  {"matched", e.matched},
                  {"outside_truth", e.outside_truth},
                  {"in_truth_gap", e.in_truth_gap},
                  {"rpe_pairs", e.rpe_pairs}};
  out["path_m"] = json_number(e.path_m);
  out["span_s"] = json_seconds(e.span_s);
  out["notes"] = e.notes;
  std::printf("%s\n", out.dump(2).c_str());
}

class EvaluateCommand final : public Command {
 public:
  std::string_view name() const noexcept override { return "evaluate"; }
  std::string_view summary() const noexcept override {
    return "Compare a trajectory with the truth: ATE, MPE, RPE, coverage";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins evaluate out/trajectory.tum recording/groundtruth.txt\n"
           "  pled-vins evaluate out/trajectory.tum mav0/state_groundtruth_estimate0/data.csv "
           "--json\n"
           "  pled-vins evaluate a.tum truth.txt --frames recording/images.txt --start 2.5";
  }

  void declare(CLI::App& app) override {
    app.add_option("TRAJECTORY", trajectory_, "Estimate, TUM form: t tx ty tz qx qy qz qw")
        ->required();
    app.add_option("TRUTH", truth_, "Truth, TUM form or EuRoC csv")->required();
    app.add_option("--frames", frames_,
                   "Stamps of the frames, for the coverage: images.txt or EuRoC data.csv "
                   "(default: the one beside TRUTH)");
    app.add_option("--start", start_s_,
                   "Coverage counts from this many seconds after the first frame: what replay's "
                   "--start was")
        ->check(CLI::NonNegativeNumber);
    app.add_option("--duration", duration_s_,
                   "... and for this many seconds: what replay's --duration was")
        ->check(CLI::PositiveNumber);
    app.add_flag("--json", json_, "Print JSON");
  }

  ExitCode run() override {
    const auto estimate = read_trajectory(trajectory_);
    if (const auto* error = std::get_if<FileError>(&estimate)) return failed(*error);
    const auto truth = read_trajectory(truth_);
    if (const auto* error = std::get_if<FileError>(&truth)) return failed(*error);
    std::optional<FrameSpan> span;
    const fs::path frames_file = frames_.empty() ? frames_beside(truth_) : fs::path(frames_);
    if (!frames_file.empty()) {
      const auto stamps = read_frame_stamps(frames_file);
      if (const auto* error = std::get_if<FileError>(&stamps)) return failed(*error);
      const auto& listed = std::get<FrameStamps>(stamps);
      span = played(listed.ns);
      if (listed.passed_over > 0)
        print_note(frames_file.string() + ": passed over " + std::to_string(listed.passed_over) +
                   " lines without a time, a path, or with a time not after the one before");
    }
    const Evaluation e =
        evaluate(std::get<Trajectory>(estimate), std::get<Trajectory>(truth), span);
    json_ ? print_json(e) : print_text(e);
    for (const std::string& note : e.notes) print_note(note);
    return ExitCode::kDone;
  }

 private:
  /// The frames that replay played with the same --start and --duration; the period is
  /// the whole recording's.
  [[nodiscard]] std::optional<FrameSpan> played(const std::vector<std::int64_t>& stamps_ns) const {
    std::optional<FrameSpan> span = frame_span(stamps_ns);
    if (!span) return span;
    const std::int64_t first_ns = stamps_ns.front();
    const auto inside = [&](std::int64_t stamp_ns) {
      const double since_s = static_cast<double>(stamp_ns - first_ns) * 1e-9;
      constexpr double kRounding_s = 1e-6;  // as replay rounds its options
      return since_s >= start_s_ - kRounding_s &&
             (!duration_s_ || since_s <= start_s_ + *duration_s_ + kRounding_s);
    };
    const auto begin = std::find_if(stamps_ns.begin(), stamps_ns.end(), inside);
    const auto end = std::find_if(stamps_ns.rbegin(), stamps_ns.rend(), inside);
    if (begin == stamps_ns.end()) return FrameSpan{first_ns, first_ns, span->period_ns};
    span->first_ns = *begin;
    span->last_ns = *end;
    return span;
  }

  static ExitCode failed(const FileError& error) {
    print_error(error.message());
    return ExitCode::kFailed;
  }

  std::string trajectory_;
  std::string truth_;
  std::string frames_;
  double start_s_ = 0.0;
  std::optional<double> duration_s_;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> make_evaluate_command() { return std::make_unique<EvaluateCommand>(); }

}  // namespace pled::apps
