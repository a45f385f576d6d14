#pragma once

#include <memory>
#include <optional>
#include <string>

#include "drivers/replay/recording.hpp"
#include "pled_vins/backend/solvers.hpp"
#include "pled_vins/backend/window_solver.hpp"
#include "pled_vins/config/app_config.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/evaluation/evaluate.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/pipeline/inline_runner.hpp"
#include "src/apps/estimator_storage.hpp"

namespace pled::apps {

/// Which recording is played, and what of it.
struct PlayOptions {
  std::string recording;
  std::string config;  ///< empty: the recording's own settings, else the built-in ones
  double start_s = 0.0;
  std::optional<double> duration_s;
  bool use_frames = true;  ///< false: they give only the times of observations
  bool use_events = true;
  std::optional<TemporalScore> score;  ///< instead of that of the settings
  bool all_scores = false;             ///< compute those too that are not given out
  SolverKind solver = SolverKind::kFixed;
};

/// The opened streams of a recording.
struct Streams {
  std::unique_ptr<FrameSource> frames;
  replay::RecordedFrameSource* frame_file = nullptr;  ///< the same, when there are pictures
  std::unique_ptr<replay::RecordedImuSource> imu;
  std::optional<replay::EventReplay> events;

  [[nodiscard]] RunSources sources() const;
};

/// A recording with its calibration, ready to be played once, and again after each rewind().
struct OpenedRecording {
  PlayOptions options;
  AppConfig config;
  replay::Recording recording;
  RigCalibration rig;
  const limits::SensorClass* sensor = nullptr;
  double whole_s = 0.0;                   ///< from the first observation to the last
  std::optional<FrameSpan> observations;  ///< of the whole recording; absent with fewer than two
  Streams streams;

  [[nodiscard]] EstimatorParts build(WindowSolver& solver) const;
  /// Opens the streams anew, each at its beginning. Prints why when that fails, and is false.
  [[nodiscard]] bool rewind();
  [[nodiscard]] RunSpan span() const;
  /// Seconds that will be played.
  [[nodiscard]] double played_s() const;
};

/// Opens everything and prints what is wrong; nullopt when it cannot be played.
[[nodiscard]] std::optional<OpenedRecording> open_recording(const PlayOptions& options);

}  // namespace pled::apps
