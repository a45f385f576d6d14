#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "pled_vins/pipeline/latency_histogram.hpp"

namespace pled {

/// Everything that can go wrong and still leave the estimator running. Counted,
/// never silent; the names are those of report.json.
enum class Fault : std::uint8_t {
  kEventOutsideSensor,
  kEventTimeBackwards,
  kEventMalformed,
  kEventGap,
  kEventStampWild,      ///< far from the stamps before it
  kEventHotPixel,       ///< from a pixel that fires faster than any scene makes it
  kEventShed,           ///< beyond the highest rate that is looked at
  kEventWithoutTurn,    ///< time surfaces drawn, or events left out of the map, without gyro
  kEventMapFull,        ///< beyond the 255th of a pixel of the map in one time bin
  kEventMapLate,        ///< older than the map's window
  kEventMapOutside,     ///< carried out of the map by the camera's turning, lens or hole of it
  kEventTurnGap,        ///< holes of the gyro, or its clock set back: the turn is not known across
  kEventTurnDropped,    ///< gyro samples that the turn could not use
  kFrameWithoutEvents,  ///< played after the event stream had ended
  kImuGap,
  kImuDuplicate,
  kImuBackwards,
  kImuUnreadable,
  kImuStampWild,
  kImuNotFinite,
  kImuImplausible,
  kFrameUnreadable,
  kFrameOutOfOrder,
  kFrameStampWild,
  kFrameWrongSize,
  kFrameWithoutImu,
  kLinePictureSkipped,  ///< no line was looked for: the picture had another size, or memory ran out
  kClockJump,
  kEstimatorReset,
  kTimeShiftCorrected,  ///< the clocks of camera and IMU were found to be apart
  kCount,
};

[[nodiscard]] std::string_view to_string(Fault fault) noexcept;

struct StreamCounts {
  std::uint64_t in = 0;
  std::uint64_t used = 0;
  std::uint64_t dropped = 0;
};

enum class Stage : std::uint8_t {
  kRead,
  kEvents,
  kFrontend,
  kLines,
  kScores,
  kBackend,
  kFrame,
  kCount
};

[[nodiscard]] std::string_view to_string(Stage stage) noexcept;

/// Counters and timings of one run.
class Health {
 public:
  void count(Fault fault, std::uint64_t n = 1) noexcept {
    faults_[static_cast<std::size_t>(fault)] += n;
  }
  void set(Fault fault, std::uint64_t n) noexcept { faults_[static_cast<std::size_t>(fault)] = n; }
  [[nodiscard]] std::uint64_t faults(Fault fault) const noexcept {
    return faults_[static_cast<std::size_t>(fault)];
  }
  [[nodiscard]] LatencyHistogram& stage(Stage stage) noexcept {
    return stages_[static_cast<std::size_t>(stage)];
  }
  [[nodiscard]] const LatencyHistogram& stage(Stage stage) const noexcept {
    return stages_[static_cast<std::size_t>(stage)];
  }

  StreamCounts events;
  StreamCounts imu;
  StreamCounts frames;

 private:
  std::array<std::uint64_t, static_cast<std::size_t>(Fault::kCount)> faults_{};
  std::array<LatencyHistogram, static_cast<std::size_t>(Stage::kCount)> stages_{};
};

/// Measures the CPU time of its thread until it goes out of scope into one stage of `health`.
class StageTimer {
 public:
  StageTimer(Health& health, Stage stage) noexcept;
  ~StageTimer();
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  LatencyHistogram& histogram_;
  std::int64_t started_ns_;
};

}  // namespace pled
