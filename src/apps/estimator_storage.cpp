#include "src/apps/estimator_storage.hpp"

#include <array>
#include <memory>
#include <optional>

#include "pled_vins/core/check.hpp"

// The only statics of the estimator: libraries own none.

namespace pled::apps {
namespace {

/// Memory that grows with the sensor.
template <int Width, int Height>
struct SensorStorage {
  FrameTrackerStorage<Width, Height> tracker;
  EventStageStorage<Width, Height> events;
  LineStorage<Width, Height> lines;
};

#define PLED_SENSOR_STORAGE(sensor, member) \
  SensorStorage<limits::sensor.width_px, limits::sensor.height_px> member

#if defined(PLED_SENSOR_DAVIS240) || defined(PLED_SENSOR_ALL)
PLED_SENSOR_STORAGE(kDavis240, storage_davis240);
#endif
#if defined(PLED_SENSOR_DAVIS346) || defined(PLED_SENSOR_ALL)
PLED_SENSOR_STORAGE(kDavis346, storage_davis346);
#endif
#if defined(PLED_SENSOR_VGA) || defined(PLED_SENSOR_ALL)
PLED_SENSOR_STORAGE(kVga, storage_vga);
#endif
#if defined(PLED_SENSOR_WVGA) || defined(PLED_SENSOR_ALL)
PLED_SENSOR_STORAGE(kWvga, storage_wvga);
#endif
#if defined(PLED_SENSOR_HD) || defined(PLED_SENSOR_ALL)
PLED_SENSOR_STORAGE(kHd, storage_hd);
#endif

struct ClassStorage;

/// Memory that every class needs alike.
struct CommonStorage {
  const ClassStorage* in_use = nullptr;
  ImuHistory imu;
  Health health;
  std::optional<FrameTracker> tracker;
  std::optional<Backend> backend;
  std::optional<EventStage> events;
  std::optional<LineStage> lines;
  std::optional<VioPipeline> pipeline;
  std::optional<InlineRunner> runner;
};

CommonStorage common;

template <typename Storage>
constexpr std::array<BufferInfo, 20> table_of() {
  using Tracker = decltype(Storage::tracker);
  using Events = decltype(Storage::events);
  return {{
      {"tracker.pyramids", sizeof(Tracker::pyramids)},
      {"tracker.corner_response", sizeof(Tracker::response) + sizeof(Tracker::corner_rows) +
                                      sizeof(Tracker::row) + sizeof(Tracker::corner_cells)},
      {"tracker.mask", sizeof(Tracker::mask)},
      {"tracker.reference_patches", sizeof(Tracker::reference_patches)},
      {"tracker.tracks", sizeof(std::optional<FrameTracker>)},
      {"events.bearings", sizeof(Events::bearings)},
      {"events.surface", sizeof(Events::pixels)},
      {"events.brightness", sizeof(Events::brightness) + sizeof(Events::brightness_picture)},
      {"events.time_surface", sizeof(Events::drawing) + sizeof(Events::surface_picture)},
      {"events.pyramids", sizeof(Events::pyramids) + sizeof(Events::row)},
      {"events.reference_patches", sizeof(Events::reference_patches)},
      {"events.map", sizeof(Events::map)},
      {"events.stage", sizeof(std::optional<EventStage>)},
      {"lines.pictures", sizeof(Storage::lines)},
      {"lines.stage", sizeof(std::optional<LineStage>)},
      {"imu.history", sizeof(ImuHistory)},
      {"backend.window", sizeof(std::optional<Backend>)},
      {"pipeline.messages", sizeof(std::optional<VioPipeline>)},
      {"pipeline.event_batch", sizeof(std::optional<InlineRunner>)},
      {"health.counters", sizeof(Health)},
  }};
}

/// Where the memory of one class lies, if this build has it.
struct ClassStorage {
  const limits::SensorClass* sensor;
  FrameTrackerBuffers (*tracker)();
  EventStageBuffers (*events)();
  LineBuffers (*lines)();
  void (*renew)();
  std::span<const BufferInfo> table;
};

template <auto& storage>
FrameTrackerBuffers tracker_of() {
  return storage.tracker.view();
}

template <auto& storage>
EventStageBuffers events_of() {
  return storage.events.view();
}

/// In place: a copy would not fit on the stack.
template <typename Storage>
void renew_in_place(Storage& storage) {
  std::destroy_at(&storage);
  std::construct_at(&storage);
}

template <auto& storage>
void renew() {
  renew_in_place(storage);
}

template <auto& storage>
LineBuffers lines_of() {
  return storage.lines.view();
}

template <auto& storage>
constexpr auto kTable = table_of<std::remove_reference_t<decltype(storage)>>();

template <auto& storage>
constexpr ClassStorage class_storage(const limits::SensorClass& sensor) {
  return {&sensor,           tracker_of<storage>, events_of<storage>,
          lines_of<storage>, renew<storage>,      kTable<storage>};
}

constexpr std::array kClassStorage = {
#if defined(PLED_SENSOR_DAVIS240) || defined(PLED_SENSOR_ALL)
    class_storage<storage_davis240>(limits::kDavis240),
#endif
#if defined(PLED_SENSOR_DAVIS346) || defined(PLED_SENSOR_ALL)
    class_storage<storage_davis346>(limits::kDavis346),
#endif
#if defined(PLED_SENSOR_VGA) || defined(PLED_SENSOR_ALL)
    class_storage<storage_vga>(limits::kVga),
#endif
#if defined(PLED_SENSOR_WVGA) || defined(PLED_SENSOR_ALL)
    class_storage<storage_wvga>(limits::kWvga),
#endif
#if defined(PLED_SENSOR_HD) || defined(PLED_SENSOR_ALL)
    class_storage<storage_hd>(limits::kHd),
#endif
};

template <typename T>
T* pointer_to(std::optional<T>& part) noexcept {
  return part ? &*part : nullptr;
}

const ClassStorage* find(const limits::SensorClass& sensor) noexcept {
  for (const ClassStorage& storage : kClassStorage)
    if (storage.sensor->name == sensor.name) return &storage;
  return nullptr;
}

}  // namespace

EstimatorParts build_estimator(const limits::SensorClass& sensor, const RigCalibration& rig,
                               const EstimatorSettings& settings, WindowSolver& solver) {
  const ClassStorage* storage = find(sensor);
  PLED_CHECK(storage != nullptr);
  PLED_CHECK(common.in_use == nullptr);
  common.in_use = storage;
  common.tracker.emplace(settings.frontend, Camera(rig.cameras[rig.frame_camera]),
                         storage->tracker(),
                         TrackerRole{rig.frame_camera, FeatureKind::kImagePoint});
  if (settings.events) common.events.emplace(*settings.events, rig, storage->events());
  if (settings.lines.source != LineSource::kNone)
    common.lines.emplace(settings.lines, rig, storage->lines());
  common.backend.emplace(settings.backend, rig, solver);
  common.pipeline.emplace(rig, common.imu, *common.tracker, *common.backend, common.health,
                          settings.pipeline, pointer_to(common.events), pointer_to(common.lines));
  common.runner.emplace(*common.pipeline, common.health);
  return {&common.imu,
          &common.health,
          &*common.tracker,
          pointer_to(common.events),
          pointer_to(common.lines),
          &*common.backend,
          &*common.pipeline,
          &*common.runner};
}

void release_estimator() noexcept {
  const ClassStorage* storage = common.in_use;
  if (storage == nullptr) return;
  renew_in_place(common);
  storage->renew();
}

const limits::SensorClass* smallest_class(int width_px, int height_px) noexcept {
  for (const limits::SensorClass& sensor : limits::kSensorClasses)
    if (width_px <= sensor.width_px && height_px <= sensor.height_px) return &sensor;
  return nullptr;
}

const limits::SensorClass* class_by_name(std::string_view name) noexcept {
  for (const limits::SensorClass& sensor : limits::kSensorClasses)
    if (sensor.name == name) return &sensor;
  return nullptr;
}

bool has_storage(const limits::SensorClass& sensor) noexcept { return find(sensor) != nullptr; }

std::span<const BufferInfo> memory_table(const limits::SensorClass& sensor) noexcept {
  const ClassStorage* storage = find(sensor);
  return storage == nullptr ? std::span<const BufferInfo>{} : storage->table;
}

std::size_t static_bytes(const limits::SensorClass& sensor) noexcept {
  std::size_t sum = 0;
  for (const BufferInfo& buffer : memory_table(sensor)) sum += buffer.bytes;
  return sum;
}

}  // namespace pled::apps
