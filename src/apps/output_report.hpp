#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pled::apps {

/// Accuracy against the truth; absent without truth or without a start.
struct AccuracyReport {
  std::optional<double> ate_rmse_m;
  std::optional<double> mpe_percent;
  std::optional<double> rpe_trans_m;
  std::optional<double> rpe_rot_deg;
  std::optional<double> coverage;
};

/// Time of one stage per frame.
struct StageReport {
  std::string name;
  std::optional<double> p50_us;
  std::optional<double> p99_us;
  std::optional<double> max_us;
};

/// What became of the data of one sensor.
struct FlowReport {
  std::uint64_t in = 0;
  std::uint64_t used = 0;
  std::uint64_t dropped = 0;
};

/// Features in a frame, on average.
struct FeatureReport {
  std::optional<double> image_points;
  std::optional<double> event_points;
  std::optional<double> lines;
};

struct MemoryReport {
  std::optional<std::uint64_t> static_bytes;
  std::optional<std::uint64_t> peak_rss_bytes;
  std::optional<std::uint64_t> allocations_after_start;
};

/// report.json of a replay. What is absent is written as null, never left out.
struct ReplayReport {
  static constexpr const char* kFileName = "report.json";
  /// The settings that the run was done with, beside it.
  static constexpr const char* kConfigFileName = "config.yaml";
  static constexpr const char* kSchema = "pled-vins/replay-report/1";

  std::string version;  ///< of the program that made it
  std::string recording;
  std::optional<double> duration_s;        ///< of the recording, as replayed
  std::optional<double> initialised_at_s;  ///< after the first frame replayed
  AccuracyReport accuracy;
  std::vector<StageReport> stages;
  std::optional<double> cpu_ms_per_frame;
  FeatureReport features_per_frame;
  bool saw_frames = true;  ///< false: they gave only the times of observations
  bool saw_events = true;
  std::optional<FlowReport> events;
  std::optional<FlowReport> imu;
  std::optional<FlowReport> frames;
  MemoryReport memory;
  std::vector<std::pair<std::string, std::uint64_t>> faults;  ///< kind and count
  std::uint64_t resets = 0;
  std::vector<double> reset_stamps_s;  ///< of the first frame after each, as the recording has it
};

/// The report as JSON text, keys in the order of the struct.
[[nodiscard]] std::string to_json(const ReplayReport& report);

/// Writes FOLDER/report.json. Returns what went wrong, empty when nothing did.
[[nodiscard]] std::string write_report(const ReplayReport& report,
                                       const std::filesystem::path& folder);

}  // namespace pled::apps
