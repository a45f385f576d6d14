#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <vector>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/core/result.hpp"
#include "pled_vins/sim/evt3_encoder.hpp"
#include "pled_vins/sim/imu_model.hpp"
#include "pled_vins/sim/options.hpp"
#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/frame_model.hpp"

namespace pled::sim {

/// A frame that was written, and its stamp.
struct ListedFrame {
  std::uint64_t index = 0;
  double stamp_s = 0.0;
};

/// Puts a recording on disk, piece by piece. Every call may fail with kIoFailure.
class RecordingWriter {
 public:
  explicit RecordingWriter(std::filesystem::path out_dir) : dir_(std::move(out_dir)) {}

  /// Makes the folders, removes what an earlier recording left, opens events.raw or events.txt.
  Result<void> create(const SimulationOptions& options);
  /// camchain.yaml, calib.txt and imu.yaml; with two cameras also settings.yaml, which names them.
  Result<void> write_calibration(const SimulationOptions& options);
  Result<void> write_imu(std::span<const ImuSample> samples);
  /// Body poses at `rate_hz` from 0 to `duration_s`, both included.
  Result<void> write_truth(const Trajectory& trajectory, double duration_s, double rate_hz);
  /// states.csv in EuRoC's columns: pose, velocity and biases at each inertial sample.
  Result<void> write_states(const Trajectory& trajectory, const SimulatedImu& imu);
  Result<void> write_frame(std::uint64_t index, const Frame& frame, int width_px, int height_px);
  /// images.txt, masks.txt and, with depth, depth.txt.
  Result<void> write_frame_lists(std::span<const ListedFrame> frames);
  /// Events in time order, also from call to call.
  Result<void> write_events(std::span<const Event> events);
  Result<void> finish();

 private:
  std::filesystem::path dir_;
  bool with_depth_ = false;
  bool text_events_ = false;
  std::ofstream events_;
  Evt3Encoder encoder_{0};
  std::vector<std::byte> bytes_;
};

}  // namespace pled::sim
