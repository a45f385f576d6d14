#pragma once

#include <filesystem>
#include <string>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/hal/pose_sink.hpp"
#include "src/apps/output_file.hpp"

namespace pled::apps {

/// trajectory.tum: `t tx ty tz qx qy qz qw`, T_world_body, one line a pose, 9
/// decimals, stamps as the recording has them. Each line is handed to the system at
/// once, so nothing is lost when the process dies.
class TrajectoryWriter final : public PoseSink {
 public:
  static constexpr const char* kFileName = "trajectory.tum";

  bool open(const std::filesystem::path& folder) { return file_.open(folder / kFileName); }
  /// Errors: kBadNumber (not finite; nothing written), kIoFailure.
  Result<void> write(const PoseEstimate& pose) noexcept override;
  bool close() noexcept { return file_.close(); }
  [[nodiscard]] std::string error() const { return file_.error(); }

 private:
  OutputFile file_;
};

}  // namespace pled::apps
