#include <array>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "src/apps/ablation_run.hpp"
#include "src/apps/commands.hpp"
#include "src/apps/json_number.hpp"
#include "src/apps/opened_recording.hpp"
#include "src/apps/stream_options.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

using nlohmann::ordered_json;

constexpr int kMostStarts = 50;

/// To a tenth of a millimetre, or of a thousandth.
std::string fine_text(const std::optional<double>& value) {
  if (!value) return "-";
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.4f", *value);
  return buffer.data();
}

std::string both_text(const MedianWorst& figure, int starts) {
  std::string text = fine_text(figure.median);
  if (starts > 1) text.append(" ").append(fine_text(figure.worst));
  return text;
}

void print_cells(const std::array<std::string, 6>& cells) {
  std::printf("  | %6s %6s %13s %14s %7s %6s", cells[0].c_str(), cells[1].c_str(), cells[2].c_str(),
              cells[3].c_str(), cells[4].c_str(), cells[5].c_str());
}

void print_quality(const WeightQuality& q) {
  const std::size_t rows = q.n_static + q.n_dynamic;
  std::string mae = figure_text(q.mae);
  if (q.mae) mae.append(" (").append(figure_text(q.mae_of_one())).append(")");
  print_cells({rows == 0 ? "-" : std::to_string(rows), figure_text(q.auc), mae,
               figure_text(q.mae_balanced), figure_text(q.w_ratio), figure_text(q.mean_static)});
}

/// Of ATE and coverage.
int figure_width(int starts) { return starts > 1 ? 13 : 6; }

void print_heading(const std::string& sequence, int starts) {
  const int width = figure_width(starts);
  std::printf("%-40s %*s", sequence.c_str(), 2 * width + 1, "");
  std::printf("  | %-57s  | %s\n", "points", "lines");
  std::printf("%-8s %-18s %-12s %*s %*s", "method", "weights from", "features", width, "ATE m",
              width, "cover");
  for (int kind = 0; kind < 2; ++kind)
    print_cells({"rows", "AUC", "MAE (w=1)", "balanced (0.5)", "w_ratio", "static"});
  std::printf("\n");
}

void print_row(const AblationResult& result, int starts, std::string_view rows) {
  const int width = figure_width(starts);
  std::printf("%-8s %-18s %-12s %*s %*s", method_name(result.ablation).data(),
              evidence_name(result.ablation).data(), features_name(result.ablation).data(), width,
              both_text(result.ate_m, starts).c_str(), width,
              both_text(result.coverage, starts).c_str());
  for (const AblationQuality& quality : result.quality)
    if (quality.rows == rows) print_quality(quality.judgement.quality);
  std::printf("\n");
}

ordered_json json_of(const AblationResult& result, const std::string& sequence, int starts) {
  ordered_json out{{"sequence", sequence},
                   {"method", method_name(result.ablation)},
                   {"weights_from", evidence_name(result.ablation)},
                   {"features", features_name(result.ablation)},
                   {"starts", starts},
                   {"ate_rmse_m", json_number(result.ate_m.median)},
                   {"ate_rmse_m_worst", json_number(result.ate_m.worst)},
                   {"coverage", json_number(result.coverage.median)},
                   {"coverage_worst", json_number(result.coverage.worst)}};
  ordered_json rows = ordered_json::array();
  for (const AblationQuality& quality : result.quality) {
    const WeightQuality& q = quality.judgement.quality;
    const bool two_classes = q.mae_balanced.has_value();
    rows.push_back(
        {{"kind", quality.kind},
         {"rows", quality.rows},
         {"auc", json_number(q.auc)},
         {"mae", json_number(q.mae)},
         {"mae_of_1", json_number(q.mae_of_one())},
         {"mae_balanced", json_number(q.mae_balanced)},
         {"mae_balanced_of_1", json_number(two_classes ? std::optional(0.5) : std::nullopt)},
         {"w_ratio", json_number(q.w_ratio)},
         {"w_static", json_number(q.mean_static)},
         {"n_static", q.n_static},
         {"n_dynamic", q.n_dynamic},
         {"n_no_evidence", quality.judgement.no_evidence}});
  }
  out["weights"] = std::move(rows);
  return out;
}

/// Plays recordings as each configuration of the paper's ablation has it.
class AblateCommand final : public Command {
 public:
  std::string_view name() const noexcept override { return "ablate"; }
  std::string_view summary() const noexcept override {
    return "Compare the ways to weigh features: accuracy, and how well weights tell what moves";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins ablate recording\n"
           "  pled-vins ablate parking street --starts 10\n"
           "  pled-vins ablate recording --json > ablation.json\n\n"
           "One row for each configuration: no weights, weights from geometry, from geometry and\n"
           "time; with points, with points and lines; by the method of the settings ('default'),\n"
           "of the paper and of DynaVINS with their published settings. With --starts N, ATE and\n"
           "coverage are the median and the worst of N starts 0.2 s apart; the other figures are\n"
           "those of the weight that counts over all features of the first. They need labels\n"
           "(masks.txt), ATE and coverage the truth (groundtruth.txt); '-' is what nobody can "
           "tell.\n"
           "AUC 0.5 is a coin; in brackets is what a weight of 1 for everything would get; static\n"
           "is the mean weight of what is at rest; rows are those of which the weight says "
           "something.\n"
           "Where time speaks too, more features have a weight: --used compares like with like.\n"
           "`pled-vins score` tells more of one configuration.";
  }

  void declare(CLI::App& app) override {
    app.add_option("RECORDING", recordings_, "Folders of recordings")->required();
    app.add_option(
        "--config", play_.config,
        "Settings file (YAML) that configurations start from; default: built-in settings");
    app.add_option("--starts", starts_, "Runs of each configuration, 0.2 s apart")
        ->check(CLI::Range(1, kMostStarts));
    add_stream_options(app, play_);
    app.add_flag("--used", used_, "In the table, judge only features that took part in the solve");
    app.add_flag("--json", json_, "Print a JSON array, and nothing else");
  }

  ExitCode run() override {
    // All of them first: an hour later is too late to say that the last is not there.
    std::vector<OpenedRecording> opened;
    for (const std::string& recording : recordings_) {
      PlayOptions options = play_;
      options.recording = recording;
      std::optional<OpenedRecording> one = open_recording(options);
      if (!one || !is_long_enough(*one) || !is_judgeable(*one)) return ExitCode::kFailed;
      opened.push_back(std::move(*one));
    }
    ordered_json out = ordered_json::array();
    bool all_done = true;
    for (OpenedRecording& recording : opened) all_done = play(recording, out) && all_done;
    if (json_) std::printf("%s\n", out.dump(1).c_str());
    return all_done ? ExitCode::kDone : ExitCode::kFailed;
  }

 private:
  [[nodiscard]] bool is_long_enough(const OpenedRecording& opened) const {
    const double last_s = (starts_ - 1) * kAblationStartStep_s;
    if (last_s <= opened.whole_s) return true;
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), ": the last of %d starts, at %g s, lies behind its end",
                  starts_, last_s);
    print_error(opened.options.recording + text.data());
    return false;
  }

  /// Says what will be missing. False when there are labels and they cannot be read.
  [[nodiscard]] static bool is_judgeable(const OpenedRecording& opened) {
    const replay::Recording& recording = opened.recording;
    const std::string& name = opened.options.recording;
    if (!recording.has(replay::Stream::kTruth))
      print_note(name + " has no truth: there will be no ATE");
    if (recording.has(replay::Stream::kMasks)) return labels_can_be_read(recording);
    print_note(name + " has no labels: nothing can be said of the weights");
    return true;
  }

  /// False when not all of it could be read; what was found out up to there is told.
  [[nodiscard]] bool play(OpenedRecording& opened, ordered_json& out) const {
    const std::string sequence = sequence_name(opened.options.recording);
    AblationRuns runs(opened, starts_);
    std::vector<AblationResult> results;
    for (const Ablation& ablation : kAblations) {
      const std::optional<AblationResult> result = runs.play(ablation);
      if (!result) break;
      results.push_back(*result);
    }
    const bool read_all = runs.finish() && results.size() == kAblations.size();
    if (!json_) print_heading(sequence, starts_);
    for (const AblationResult& result : results) {
      if (json_)
        out.push_back(json_of(result, sequence, starts_));
      else
        print_row(result, starts_, used_ ? "used" : "all");
    }
    return read_all;
  }

  std::vector<std::string> recordings_;
  PlayOptions play_;
  int starts_ = 1;
  bool used_ = false;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> make_ablate_command() { return std::make_unique<AblateCommand>(); }

}  // namespace pled::apps
