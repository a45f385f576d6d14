#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "drivers/replay/recording.hpp"

namespace pled::replay {

struct EventInfo {
  bool present = false;
  std::uint64_t count = 0;
  double first_s = 0.0;
  double last_s = 0.0;
  double rate_hz = 0.0;  ///< count over the time between the first and the last
  int width = 0;
  int height = 0;
};

struct ImuInfo {
  bool present = false;
  std::uint64_t count = 0;
  double first_s = 0.0;
  double last_s = 0.0;
  double rate_hz = 0.0;    ///< from the median interval
  std::uint64_t gaps = 0;  ///< intervals > max(4 * median, 25 ms)
  double longest_gap_s = 0.0;
  std::uint64_t duplicates = 0;  ///< stamps equal to the one before
  std::uint64_t backwards = 0;   ///< stamps before the latest so far
};

struct FrameInfo {
  bool present = false;
  std::uint64_t count = 0;  ///< readable and in order
  double first_s = 0.0;
  double last_s = 0.0;
  double rate_hz = 0.0;    ///< intervals over the time between the first and the last
  std::uint64_t gaps = 0;  ///< intervals > max(4.5 * median, 100 ms)
  double longest_gap_s = 0.0;
  int width = 0;
  int height = 0;
};

struct MaskInfo {
  bool present = false;
  std::uint64_t count = 0;  ///< readable and in order
};

struct TruthInfo {
  bool present = false;
  std::uint64_t count = 0;
  double first_s = 0.0;
  double last_s = 0.0;
};

struct TriggerInfo {
  bool present = false;     ///< the recording is a container that may hold some
  std::uint64_t count = 0;  ///< known and not used
};

/// What `pled-vins info` prints.
struct RecordingInfo {
  EventInfo events;
  ImuInfo imu;
  FrameInfo frames;
  TruthInfo truth;
  MaskInfo masks;
  TriggerInfo triggers;
  std::vector<std::string> problems;  ///< at most kMaxProblemsOfAKind each, then a count
};

inline constexpr std::uint64_t kMaxProblemsOfAKind = 5;

/// Reads the whole recording once (the inertial file twice) with memory that
/// does not grow with its length, but for 8 bytes a listed frame. `progress` is called
/// with rising values in [0, 1] and may be empty. Errors: kIoFailure, kUnsupported (a
/// single file that holds no events after all); their words are in `problems`.
[[nodiscard]] Result<RecordingInfo> survey(const Recording& recording, Problems& problems,
                                           const std::function<void(double)>& progress);

}  // namespace pled::replay
