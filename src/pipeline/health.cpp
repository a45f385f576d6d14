#include "pled_vins/pipeline/health.hpp"

#include <ctime>

namespace pled {
namespace {

std::int64_t thread_cpu_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

std::string_view to_string(Fault fault) noexcept {
  switch (fault) {
    case Fault::kEventOutsideSensor: return "event_outside_sensor";
    case Fault::kEventTimeBackwards: return "event_time_backwards";
    case Fault::kEventMalformed: return "event_malformed";
    case Fault::kEventGap: return "event_gap";
    case Fault::kEventStampWild: return "event_stamp_wild";
    case Fault::kEventHotPixel: return "event_hot_pixel";
    case Fault::kEventShed: return "event_shed";
    case Fault::kEventWithoutTurn: return "event_without_turn";
    case Fault::kEventMapFull: return "event_map_full";
    case Fault::kEventMapLate: return "event_map_late";
    case Fault::kEventMapOutside: return "event_map_outside";
    case Fault::kEventTurnGap: return "event_turn_gap";
    case Fault::kEventTurnDropped: return "event_turn_dropped";
    case Fault::kImuGap: return "imu_gap";
    case Fault::kImuDuplicate: return "imu_duplicate";
    case Fault::kImuBackwards: return "imu_backwards";
    case Fault::kImuUnreadable: return "imu_unreadable";
    case Fault::kImuNotFinite: return "imu_not_finite";
    case Fault::kImuImplausible: return "imu_implausible";
    case Fault::kImuStampWild: return "imu_stamp_wild";
    case Fault::kFrameStampWild: return "frame_stamp_wild";
    case Fault::kLinePictureSkipped: return "line_picture_skipped";
    case Fault::kClockJump: return "clock_jump";
    case Fault::kFrameUnreadable: return "frame_unreadable";
    case Fault::kFrameOutOfOrder: return "frame_out_of_order";
    case Fault::kFrameWrongSize: return "frame_wrong_size";
    case Fault::kFrameWithoutEvents: return "frame_without_events";
    case Fault::kFrameWithoutImu: return "frame_without_imu";
    case Fault::kEstimatorReset: return "estimator_reset";
    case Fault::kTimeShiftCorrected: return "time_shift_corrected";
    case Fault::kCount: break;
  }
  return "unknown";
}

std::string_view to_string(Stage stage) noexcept {
  switch (stage) {
    case Stage::kRead: return "read";
    case Stage::kEvents: return "events";
    case Stage::kFrontend: return "frontend";
    case Stage::kLines: return "lines";
    case Stage::kScores: return "scores";
    case Stage::kBackend: return "backend";
    case Stage::kFrame: return "frame";
    case Stage::kCount: break;
  }
  return "unknown";
}

StageTimer::StageTimer(Health& health, Stage stage) noexcept
    : histogram_(health.stage(stage)), started_ns_(thread_cpu_ns()) {}

StageTimer::~StageTimer() { histogram_.add_ns(thread_cpu_ns() - started_ns_); }

}  // namespace pled
