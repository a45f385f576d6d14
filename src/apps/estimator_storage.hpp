#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "pled_vins/backend/backend.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/frontend/frame_tracker.hpp"
#include "pled_vins/imu/imu_history.hpp"
#include "pled_vins/pipeline/event_stage.hpp"
#include "pled_vins/pipeline/health.hpp"
#include "pled_vins/pipeline/inline_runner.hpp"
#include "pled_vins/pipeline/line_stage.hpp"
#include "pled_vins/pipeline/vio_pipeline.hpp"

namespace pled::apps {

/// One row of the memory table.
struct BufferInfo {
  std::string_view name;
  std::size_t bytes = 0;
};

/// The stages of one estimator, living in the program's static memory.
struct EstimatorParts {
  ImuHistory* imu = nullptr;
  Health* health = nullptr;
  FrameTracker* tracker = nullptr;
  EventStage* events = nullptr;  ///< null: events are not looked at
  LineStage* lines = nullptr;    ///< null: no lines are looked for
  Backend* backend = nullptr;
  VioPipeline* pipeline = nullptr;
  InlineRunner* runner = nullptr;
};

/// How the stages work.
struct EstimatorSettings {
  FrontendConfig frontend;
  BackendConfig backend;
  std::optional<EventStageConfig> events;  ///< nullopt: events are only counted
  LineStageConfig lines;                   ///< its source: only what is looked at
  PipelineOptions pipeline;
};

/// Builds the estimator in the static memory of `sensor`, which must have some in
/// this build. The memory is one: before another is built, this one must be released.
[[nodiscard]] EstimatorParts build_estimator(const limits::SensorClass& sensor,
                                             const RigCalibration& rig,
                                             const EstimatorSettings& settings,
                                             WindowSolver& solver);

/// Ends the estimator and leaves its memory as the process found it: the next one built knows
/// nothing of it. The parts are gone. Does nothing when there is none.
void release_estimator() noexcept;

/// The smallest class that holds a sensor of this size; null when none does.
[[nodiscard]] const limits::SensorClass* smallest_class(int width_px, int height_px) noexcept;
/// By its name; null when there is none.
[[nodiscard]] const limits::SensorClass* class_by_name(std::string_view name) noexcept;
/// True when this build has storage for the class: all on the desktop, one onboard
/// (PLED_SENSOR).
[[nodiscard]] bool has_storage(const limits::SensorClass& sensor) noexcept;

/// What an estimator of the class keeps, buffer by buffer; empty without storage.
[[nodiscard]] std::span<const BufferInfo> memory_table(const limits::SensorClass& sensor) noexcept;
/// Sum of memory_table().
[[nodiscard]] std::size_t static_bytes(const limits::SensorClass& sensor) noexcept;

}  // namespace pled::apps
