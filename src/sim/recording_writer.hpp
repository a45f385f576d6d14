#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <vector>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/core/result.hpp"
#include "pled_vins/sim/evt3_encoder.hpp"
#include "pled_vins/sim/options.hpp"
#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/frame_model.hpp"

namespace pled::sim {

/// Puts a recording on disk, piece by piece. Every call may fail with kIoFailure.
class RecordingWriter {
 public:
  explicit RecordingWriter(std::filesystem::path out_dir) : dir_(std::move(out_dir)) {}

  /// Makes the folders, removes pictures of an earlier recording, opens events.raw.
  Result<void> create(const CameraCalibration& camera);
  Result<void> write_calibration(const CameraCalibration& camera, const ImuNoise& imu);
  Result<void> write_imu(std::span<const ImuSample> samples);
  /// Body poses at `rate_hz` from 0 to `duration_s`, both included.
  Result<void> write_truth(const Trajectory& trajectory, double duration_s, double rate_hz);
  Result<void> write_frame(std::uint64_t index, const Frame& frame, int width_px, int height_px);
  /// images.txt and masks.txt for the frames 0 ... count - 1.
  Result<void> write_frame_lists(std::uint64_t count, double rate_hz);
  /// Events in time order, also from call to call.
  Result<void> write_events(std::span<const Event> events);
  Result<void> finish();

 private:
  std::filesystem::path dir_;
  std::ofstream events_;
  Evt3Encoder encoder_{0};
  std::vector<std::byte> bytes_;
};

}  // namespace pled::sim
