#include "src/apps/replay_summary.hpp"

#include <array>
#include <cstdio>
#include <string>
#include <variant>
#include <vector>

#include "src/apps/output_report.hpp"
#include "src/apps/recorded_truth.hpp"
#include "src/apps/run_problems.hpp"
#include "src/apps/text.hpp"
#include "src/apps/version.hpp"

namespace pled::apps {
namespace {

/// Compares what was written with the truth. Only here, after the run, memory grows with the
/// length.
AccuracyReport accuracy(const ReplayFacts& facts) {
  if (!facts.recording.has(replay::Stream::kTruth)) return {};
  const auto written = read_trajectory(facts.options.out + "/" + TrajectoryWriter::kFileName);
  if (const auto* error = std::get_if<FileError>(&written)) {
    print_error(error->message());
    return {};
  }
  const Trajectory truth = read_truth(facts.recording);
  if (truth.empty()) return {};
  const Evaluation e =
      evaluate(std::get<Trajectory>(written), truth, played_frames(facts.observations, facts.end));
  return {e.ate_rmse_m, e.mpe_percent, e.rpe_trans_m, e.rpe_rot_deg, e.coverage};
}

std::vector<StageReport> stage_reports(const Health& health) {
  std::vector<StageReport> stages;
  for (int k = 0; k < static_cast<int>(Stage::kCount); ++k) {
    const auto stage = static_cast<Stage>(k);
    const LatencyHistogram& h = health.stage(stage);
    if (h.count() == 0) continue;
    stages.push_back(
        {std::string(to_string(stage)), h.quantile_us(0.5), h.quantile_us(0.99), h.max_us()});
  }
  return stages;
}

std::vector<std::pair<std::string, std::uint64_t>> fault_counts(const ReplayFacts& facts) {
  Health& health = *facts.parts.health;
  health.count(Fault::kFrameOutOfOrder, facts.frame_faults.out_of_order);
  std::vector<std::pair<std::string, std::uint64_t>> faults;
  for (int k = 0; k < static_cast<int>(Fault::kCount); ++k) {
    const auto fault = static_cast<Fault>(k);
    if (health.faults(fault) > 0)
      faults.emplace_back(std::string(to_string(fault)), health.faults(fault));
  }
  return faults;
}

FlowReport flow(const StreamCounts& counts) { return {counts.in, counts.used, counts.dropped}; }

ReplayReport make_report(const ReplayFacts& facts, const ReplayOutput& output) {
  const Health& health = *facts.parts.health;
  ReplayReport report;
  report.version = version();
  report.recording = facts.options.play.recording;
  if (facts.end.first_stamp_ns && facts.end.last_stamp_ns) {
    report.duration_s =
        static_cast<double>(*facts.end.last_stamp_ns - *facts.end.first_stamp_ns) * 1e-9;
    if (const auto first = output.first_pose_ns())
      report.initialised_at_s = static_cast<double>(*first - *facts.end.first_stamp_ns) * 1e-9;
  }
  report.accuracy = accuracy(facts);
  report.stages = stage_reports(health);
  if (health.frames.used > 0)
    report.cpu_ms_per_frame = 1e3 * facts.meters.cpu_s() / static_cast<double>(health.frames.used);
  report.features_per_frame = {output.features_per_frame(FeatureKind::kImagePoint),
                               output.features_per_frame(FeatureKind::kEventPoint),
                               output.features_per_frame(FeatureKind::kLine)};
  report.faults = fault_counts(facts);
  report.saw_frames = facts.options.play.use_frames;
  report.saw_events = facts.recording.has(replay::Stream::kEvents) && facts.options.play.use_events;
  if (facts.recording.has(replay::Stream::kEvents)) report.events = flow(health.events);
  report.imu = flow(health.imu);
  report.frames = flow(health.frames);
  report.frames->in += facts.frame_faults.out_of_order;  // these never reach the pipeline
  report.frames->dropped += facts.frame_faults.out_of_order;
  report.memory = {static_bytes(facts.sensor), facts.meters.peak_rss_bytes(),
                   facts.meters.allocations()};
  report.resets = health.faults(Fault::kEstimatorReset);
  for (const std::int64_t stamp_ns : output.resets_ns())
    report.reset_stamps_s.push_back(static_cast<double>(stamp_ns) * 1e-9);
  return report;
}

void tell_time_shift(const ReplayFacts& facts) {
  if (facts.parts.health->faults(Fault::kTimeShiftCorrected) == 0) return;
  const double shift_s = facts.parts.pipeline->seeing_shift().seconds();
  std::array<char, 200> text{};
  std::snprintf(
      text.data(), text.size(),
      "the clocks of camera and IMU do not agree: continued with a time shift of %+.4f s; "
      "write 'timeshift_cam_imu: %.4f' into camchain.yaml to start sooner",
      shift_s, shift_s);
  print_note(text.data());
}

void print_summary(const ReplayReport& report, const ReplayOutput& output,
                   const ReplayFacts& facts) {
  std::printf("%-15s %s\n", "trajectory",
              (facts.options.out + "/" + TrajectoryWriter::kFileName).c_str());
  std::printf("%-15s %llu of %llu frames\n", "poses",
              static_cast<unsigned long long>(output.poses()),
              static_cast<unsigned long long>(report.frames->used));
  const auto figure = [](const char* name, const std::optional<double>& value, const char* unit) {
    if (value) std::printf("%-15s %.4g %s\n", name, *value, unit);
  };
  figure("started after", report.initialised_at_s, "s");
  figure("ATE RMSE", report.accuracy.ate_rmse_m, "m");
  figure("MPE", report.accuracy.mpe_percent, "% of the path");
  figure("RPE in 1 s", report.accuracy.rpe_trans_m, "m");
  figure("RPE in 1 s", report.accuracy.rpe_rot_deg, "deg");
  figure("coverage", report.accuracy.coverage, "of the frames' time");
  const FeatureReport& features = report.features_per_frame;
  if (features.lines)
    std::printf("%-15s %.0f image points, %.0f event points, %.0f lines\n", "in a frame",
                *features.image_points, *features.event_points, *features.lines);
  figure("CPU per frame", report.cpu_ms_per_frame, "ms, reading included");
  for (const StageReport& stage : report.stages)
    std::printf("  %-13s p50 %8.0f us   p99 %8.0f us   max %8.0f us\n", stage.name.c_str(),
                *stage.p50_us, *stage.p99_us, *stage.max_us);
  for (const auto& [kind, count] : report.faults)
    std::printf("%-15s %s: %llu\n", "fault", kind.c_str(), static_cast<unsigned long long>(count));
  if (report.resets > 0)
    std::printf("%-15s %llu\n", "resets", static_cast<unsigned long long>(report.resets));
}

}  // namespace

bool finish_replay(const ReplayFacts& facts, ReplayOutput& output) {
  const std::string problem = output.close();
  if (!problem.empty()) print_error(problem);
  const ReplayReport report = make_report(facts, output);
  const std::string report_problem = write_report(report, facts.options.out);
  if (!report_problem.empty()) print_error(report_problem);
  print_summary(report, output, facts);
  tell_time_shift(facts);
  const bool read_all = tell_failures(facts.end);
  if (output.poses() == 0 && !output.last_refusal().empty())
    print_note("the estimator never started: " + std::string(output.last_refusal()));
  return problem.empty() && report_problem.empty() && read_all;
}

}  // namespace pled::apps
