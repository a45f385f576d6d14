#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "pled_vins/backend/solvers.hpp"
#include "pled_vins/evaluation/weights.hpp"
#include "src/apps/commands.hpp"
#include "src/apps/json_number.hpp"
#include "src/apps/opened_recording.hpp"
#include "src/apps/problems.hpp"
#include "src/apps/progress.hpp"
#include "src/apps/run_problems.hpp"
#include "src/apps/score_rows.hpp"
#include "src/apps/solver_option.hpp"
#include "src/apps/stream_options.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

using nlohmann::ordered_json;

/// Plays a recording and tells how well each weight of a feature knows what moves.
class ScoreCommand final : public Command {
 public:
  std::string_view name() const noexcept override { return "score"; }
  std::string_view summary() const noexcept override {
    return "Measure how well the weights tell moving features from those at rest";
  }
  std::string_view examples() const noexcept override {
    return "  pled-vins score recording\n"
           "  pled-vins score recording --json > scores.json\n"
           "  pled-vins score recording --rows rows.csv\n\n"
           "The recording must have labels (masks.txt). A point's label is the mask pixel nearest\n"
           "to it, a line's that of most of the pixels at its ends and its middle. Weights: the\n"
           "temporal scores motion, paper and count; geometric, what the solve says; fused, the "
           "one\n"
           "that counts. 'all': every feature of every frame for which the weight has evidence;\n"
           "'used': those of them that took part in the solve; 'common': those for which every\n"
           "temporal score has evidence, so that scores compare like with like. AUC 0.5 is a "
           "coin;\n"
           "a constant weight has a balanced MAE of 0.5; w_ratio is the mean weight at rest over\n"
           "that of what moves; w_static the mean weight at rest.";
  }

  void declare(CLI::App& app) override {
    app.add_option("RECORDING", play_.recording, "Folder of a recording with labels")->required();
    app.add_option("--config", play_.config, "Settings file (YAML); default: built-in settings");
    add_stream_options(app, play_);
    add_solver_option(app, play_);
    app.add_flag("--json", json_, "Print a JSON array, and nothing else");
    app.add_option("--rows", rows_file_, "Write each feature of each frame to this CSV file");
  }

  ExitCode run() override {
    play_.all_scores = true;
    std::optional<OpenedRecording> opened = open_recording(play_);
    if (!opened) return ExitCode::kFailed;
    if (!has_labels(opened->recording)) return ExitCode::kFailed;
    const std::unique_ptr<WindowSolver> solver = make_solver(play_.solver);
    const EstimatorParts parts = opened->build(*solver);
    Progress progress = Progress::on_stderr(opened->played_s());
    ScoreRows rows(opened->recording, opened->rig, progress);
    if (!rows_file_.empty() && !rows.write_to(rows_file_)) {
      print_error("cannot write " + rows_file_);
      return ExitCode::kFailed;
    }
    const RunEnd end = parts.runner->run(opened->streams.sources(), opened->span(), rows);
    progress.finish();
    tell_stream_faults(*opened, *parts.health);
    const bool read_all = tell_failures(end);
    if (!rows.finish()) {
      print_error("cannot write " + rows_file_);
      return ExitCode::kFailed;
    }
    if (rows.labelled_frames() == 0) {
      print_error("no frame that was played has a label");
      return ExitCode::kFailed;
    }
    tell(rows);
    return read_all ? ExitCode::kDone : ExitCode::kFailed;
  }

 private:
  /// Before anything is played: whether there are labels that can be read, else why not.
  [[nodiscard]] bool has_labels(const replay::Recording& recording) const {
    if (!recording.has(replay::Stream::kMasks)) {
      print_error(play_.recording +
                  " has no labels: masks.txt must list an image for each frame, 255 where "
                  "something moves (pled-vins simulate writes them)");
      return false;
    }
    return labels_can_be_read(recording);
  }

  void tell(const ScoreRows& rows) const {
    ordered_json out = ordered_json::array();
    if (!json_)
      std::printf("%-9s %-12s %-6s %6s %6s %8s %8s %8s %9s %9s\n", "weight", "kind", "rows", "AUC",
                  "MAE", "balanced", "w_ratio", "w_static", "static", "moving");
    for (const ScoreTable& t : rows.tables()) {
      const WeightQuality& q = t.judgement.quality;
      if (json_) {
        out.push_back({{"sequence", sequence_name(play_.recording)},
                       {"mode", t.mode},
                       {"kind", t.kind},
                       {"rows", t.rows},
                       {"auc", json_number(q.auc)},
                       {"mae", json_number(q.mae)},
                       {"mae_balanced", json_number(q.mae_balanced)},
                       {"w_ratio", json_number(q.w_ratio)},
                       {"w_static", json_number(q.mean_static)},
                       {"n_static", q.n_static},
                       {"n_dynamic", q.n_dynamic},
                       {"n_no_evidence", t.judgement.no_evidence}});
        continue;
      }
      std::printf("%-9s %-12s %-6s %6s %6s %8s %8s %8s %9zu %9zu\n", t.mode.data(), t.kind.data(),
                  t.rows.data(), figure_text(q.auc).c_str(), figure_text(q.mae).c_str(),
                  figure_text(q.mae_balanced).c_str(), figure_text(q.w_ratio).c_str(),
                  figure_text(q.mean_static).c_str(), q.n_static, q.n_dynamic);
    }
    if (json_) std::printf("%s\n", out.dump(1).c_str());
  }

  PlayOptions play_;
  bool json_ = false;
  std::string rows_file_;
};

}  // namespace

std::unique_ptr<Command> make_score_command() { return std::make_unique<ScoreCommand>(); }

}  // namespace pled::apps
