#include "src/apps/output_report.hpp"

#include <nlohmann/json.hpp>

#include "src/apps/json_number.hpp"
#include "src/apps/output_file.hpp"

namespace pled::apps {
namespace {

using Json = nlohmann::ordered_json;

template <typename T>
Json count_or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json flow(const std::optional<FlowReport>& f) {
  if (!f) return nullptr;
  return {{"in", f->in}, {"used", f->used}, {"dropped", f->dropped}};
}

Json accuracy(const AccuracyReport& a) {
  return {{"ate_rmse_m", json_number(a.ate_rmse_m)},
          {"mpe_percent", json_number(a.mpe_percent)},
          {"rpe_trans_m", json_number(a.rpe_trans_m)},
          {"rpe_rot_deg", json_number(a.rpe_rot_deg)},
          {"coverage", json_number(a.coverage)}};
}

Json stages(const std::vector<StageReport>& list) {
  Json out = Json::object();
  for (const StageReport& stage : list) {
    out[stage.name] = {{"p50_us", json_number(stage.p50_us)},
                       {"p99_us", json_number(stage.p99_us)},
                       {"max_us", json_number(stage.max_us)}};
  }
  return out;
}

}  // namespace

std::string to_json(const ReplayReport& report) {
  Json out;
  out["schema"] = ReplayReport::kSchema;
  out["version"] = report.version;
  out["recording"] = report.recording;
  out["duration_s"] = json_seconds(report.duration_s);
  out["initialised_at_s"] = json_seconds(report.initialised_at_s);
  out["accuracy"] = accuracy(report.accuracy);
  out["stages"] = stages(report.stages);
  out["cpu_ms_per_frame"] = json_number(report.cpu_ms_per_frame);
  const FeatureReport& features = report.features_per_frame;
  out["features_per_frame"] = {{"image_points", json_number(features.image_points)},
                               {"event_points", json_number(features.event_points)},
                               {"lines", json_number(features.lines)}};
  out["streams_used"] = {{"frames", report.saw_frames}, {"events", report.saw_events}};
  out["events"] = flow(report.events);
  out["imu"] = flow(report.imu);
  out["frames"] = flow(report.frames);
  out["memory"] = {
      {"static_bytes", count_or_null(report.memory.static_bytes)},
      {"peak_rss_bytes", count_or_null(report.memory.peak_rss_bytes)},
      {"allocations_after_start", count_or_null(report.memory.allocations_after_start)}};
  out["faults"] = Json::object();
  for (const auto& [kind, count] : report.faults) out["faults"][kind] = count;
  out["resets"] = report.resets;
  out["reset_stamps_s"] = report.reset_stamps_s;
  // A folder's name may hold any bytes; they must not make the report fail.
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string write_report(const ReplayReport& report, const std::filesystem::path& folder) {
  return write_whole(folder / ReplayReport::kFileName, to_json(report));
}

}  // namespace pled::apps
