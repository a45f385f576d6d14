#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pled_vins/pipeline/inline_runner.hpp"
#include "src/apps/output_features.hpp"
#include "src/apps/output_trajectory.hpp"
#include "src/apps/progress.hpp"
#include "src/apps/replay_meters.hpp"

namespace pled::apps {

/// Writes each frame's results as they come and keeps none of them: a replay needs no more memory
/// for a longer recording.
class ReplayOutput final : public ResultSink {
 public:
  /// Starts `meters` at the first frame that is played.
  ReplayOutput(Progress& progress, ReplayMeters& meters) : progress_(progress), meters_(meters) {}

  /// Opens trajectory.tum and features.csv. Returns what went wrong, empty when ready.
  [[nodiscard]] std::string open(const std::filesystem::path& folder);
  void on_start() noexcept override { meters_.start(); }
  bool on_frame(const FrameResult& result) noexcept override;
  /// Closes the files. Returns what could not be written, empty when all was.
  [[nodiscard]] std::string close();

  [[nodiscard]] std::uint64_t poses() const noexcept { return poses_written_; }
  [[nodiscard]] std::optional<std::int64_t> first_pose_ns() const noexcept {
    return first_pose_ns_;
  }
  /// Stamps of the first frames after a reset.
  [[nodiscard]] const std::vector<std::int64_t>& resets_ns() const noexcept { return resets_ns_; }
  /// Why the estimator has not started, as of the last frame without a pose.
  [[nodiscard]] std::string_view last_refusal() const noexcept { return last_refusal_; }

  /// Features of a kind in a frame, on average; nullopt without frames.
  [[nodiscard]] std::optional<double> features_per_frame(FeatureKind kind) const noexcept;

 private:
  void count(const FrameMeasurement& frame) noexcept;

  Progress& progress_;
  ReplayMeters& meters_;
  TrajectoryWriter poses_;
  FeaturesWriter features_;
  std::uint64_t frames_ = 0;
  std::array<std::uint64_t, kFeatureKinds> features_seen_{};  ///< by kind
  std::uint64_t poses_written_ = 0;
  std::optional<std::int64_t> first_pose_ns_;
  std::vector<std::int64_t> resets_ns_;
  std::uint32_t resets_ = 0;
  std::optional<std::int64_t> first_frame_ns_;
  std::string_view last_refusal_;
};

}  // namespace pled::apps
