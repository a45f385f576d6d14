#include "src/apps/replay_session.hpp"

#include <filesystem>
#include <memory>

#include "pled_vins/backend/solvers.hpp"
#include "pled_vins/report/report.hpp"
#include "src/apps/output_file.hpp"
#include "src/apps/output_report.hpp"
#include "src/apps/replay_output.hpp"
#include "src/apps/replay_summary.hpp"
#include "src/apps/run_problems.hpp"
#include "src/apps/text.hpp"

namespace pled::apps {
namespace {

/// Makes the output folder ready and leaves in it what the run is done with. The page
/// of an earlier run goes too: it would speak of results that are no longer there.
bool prepare_results(const ReplayOptions& options, const AppConfig& config) {
  std::string refusal = prepare_output_folder(
      options.out,
      {TrajectoryWriter::kFileName, FeaturesWriter::kFileName, ReplayReport::kFileName,
       ReplayReport::kConfigFileName, report::kReportFileName},
      options.force);
  if (refusal.empty())
    refusal = write_whole(std::filesystem::path(options.out) / ReplayReport::kConfigFileName,
                          to_documented_yaml(config));
  if (!refusal.empty()) print_error(refusal);
  return refusal.empty();
}

}  // namespace

bool run_replay(const ReplayOptions& options) {
  const std::optional<OpenedRecording> opened = open_recording(options.play);
  if (!opened) return false;
  // Last: with --force it removes the results of an earlier run.
  if (!prepare_results(options, opened->config)) return false;

  const std::unique_ptr<WindowSolver> solver = make_solver(options.play.solver);
  const EstimatorParts parts = opened->build(*solver);
  Progress progress = Progress::on_stderr(opened->played_s());
  ReplayMeters meters;
  ReplayOutput output(progress, meters);
  if (const std::string problem = output.open(options.out); !problem.empty()) {
    print_error(problem);
    return false;
  }
  const Streams& streams = opened->streams;
  const RunEnd end = parts.runner->run(streams.sources(), opened->span(), output);
  meters.stop();
  progress.finish();
  tell_stream_faults(*opened, *parts.health);
  const replay::FrameFaults frame_faults =
      streams.frame_file != nullptr ? streams.frame_file->faults() : replay::FrameFaults{};
  return finish_replay({options, opened->recording, opened->observations, *opened->sensor, parts,
                        end, meters, frame_faults},
                       output);
}

}  // namespace pled::apps
