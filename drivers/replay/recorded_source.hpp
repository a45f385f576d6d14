#pragma once

#include <cstdint>
#include <string_view>

#include "pled_vins/hal/event_source.hpp"
#include "pled_vins/hal/frame_source.hpp"
#include "pled_vins/hal/imu_source.hpp"

/// The interfaces of live devices, and what only a recording can tell: how much of it has
/// been read, and words about the last fault.
namespace pled::replay {

class RecordedEventSource : public EventSource {
 public:
  /// Data bytes read so far, and in the file.
  [[nodiscard]] virtual std::int64_t position() const noexcept = 0;
  [[nodiscard]] virtual std::int64_t size() const noexcept = 0;
  /// Packets that could not be read; the chunk after one says after_gap.
  [[nodiscard]] virtual std::uint64_t lost_packets() const noexcept { return 0; }
};

class RecordedImuSource : public ImuSource {
 public:
  /// kBadNumbers so far.
  [[nodiscard]] virtual std::uint64_t malformed() const noexcept = 0;
  /// Words for the last of them: where, and what was expected.
  [[nodiscard]] virtual std::string_view last_message() const noexcept = 0;
  /// Share of the file that was read.
  [[nodiscard]] virtual double progress() const noexcept = 0;
};

/// Counted faults of recorded frames.
struct FrameFaults {
  std::uint64_t malformed_lines = 0;  ///< no stamp or no name
  std::uint64_t out_of_order = 0;     ///< stamps that go back or leap ahead; skipped
  std::uint64_t unreadable = 0;       ///< missing, truncated, corrupt or of another size
};

class RecordedFrameSource : public FrameSource {
 public:
  [[nodiscard]] virtual FrameFaults faults() const noexcept = 0;
  /// Words for the last fault: where, what is wrong. Also set for a skipped stamp.
  [[nodiscard]] virtual std::string_view last_message() const noexcept = 0;
  /// Share of the file that was read.
  [[nodiscard]] virtual double progress() const noexcept = 0;
};

}  // namespace pled::replay
