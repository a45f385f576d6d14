#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "pled_vins/core/result.hpp"
#include "pled_vins/sim/options.hpp"

namespace pled::sim {

/// What a simulation wrote.
struct SimulationSummary {
  double duration_s = 0.0;
  double path_m = 0.0;  ///< length of the body's path
  std::uint64_t frames = 0;
  std::uint64_t imu_samples = 0;
  std::uint64_t events = 0;
  std::uint64_t event_renders = 0;
};

/// Called now and then with the share that is done, 0 ... 1, from the calling thread.
using ProgressCallback = std::function<void(double)>;

/// Writes a recording into `out_dir`, which is made when missing (its parent too);
/// files of the recording layout in it are replaced, others left alone:
///   images.txt + images/, masks.txt + masks/, depth.txt + depths/ (when asked for), imu.txt,
///   groundtruth.txt (200 Hz), states.csv (EuRoC's columns: velocity and biases too), calib.txt,
///   camchain.yaml, imu.yaml, events.raw (EVT 3.0), settings.yaml (with two cameras).
/// Stamps start at 0. The same options give the same bytes, whatever the number of
/// processors. Errors: kInvalidArgument (options out of range; say which with
/// check()), kIoFailure, kTooLarge (no memory), kEndOfStream (the path of `path_file` is shorter
/// than `duration_s`), kUnsupported (the motion meets a wall or leaves the world; the detail says
/// when, ms), and before anything is written those of make_trajectory().
[[nodiscard]] Result<SimulationSummary> simulate(const SimulationOptions& options,
                                                 const std::filesystem::path& out_dir,
                                                 const ProgressCallback& progress = {}) noexcept;

}  // namespace pled::sim
