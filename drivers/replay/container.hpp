#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/replay/frame_slots.hpp"
#include "drivers/replay/problem.hpp"
#include "drivers/replay/recorded_source.hpp"
#include "pled_vins/hal/event_source.hpp"

namespace pled::replay {

/// The reader of an event file and the decoder for what it gives.
struct EventReplay {
  std::unique_ptr<RecordedEventSource> source;
  std::unique_ptr<EventDecoder> decoder;
};

/// What a pass over a container finds besides events, samples and frames.
struct ContainerInfo {
  std::uint64_t triggers = 0;      ///< known and not used
  std::vector<std::string> words;  ///< what is wrong
};

/// One file that holds several streams on one clock: AEDAT 2.0 or 4.0. Each source opens the
/// file for itself and passes over what belongs to the others.
class Container {
 public:
  /// Tells by the first bytes of a file whether it is AEDAT of any version.
  [[nodiscard]] static bool is_container(std::span<const std::byte> head) noexcept;
  /// Reads the head of a file. The error, and warnings, have their words in `problems`.
  [[nodiscard]] static Result<std::shared_ptr<const Container>> open(const std::string& path,
                                                                     Problems& problems);

  virtual ~Container() = default;

  [[nodiscard]] virtual bool has_events() const noexcept = 0;
  [[nodiscard]] virtual bool has_imu() const noexcept = 0;
  [[nodiscard]] virtual bool has_frames() const noexcept = 0;
  /// Zero when the file does not tell it.
  [[nodiscard]] virtual ImageSize event_size() const noexcept = 0;
  /// False: open_frames() needs the size that the frames have, as `max` and `one_size`.
  [[nodiscard]] virtual bool tells_frame_size() const noexcept = 0;

  /// For streams that are there. Errors: File::open's; open_frames() also kInvalidArgument
  /// when no frame can have that size.
  [[nodiscard]] virtual Result<EventReplay> open_events(ImageSize size) const = 0;
  [[nodiscard]] virtual Result<std::unique_ptr<RecordedImuSource>> open_imu() const = 0;
  [[nodiscard]] virtual Result<std::unique_ptr<RecordedFrameSource>> open_frames(
      const FrameSlots::Options& options) const = 0;

  /// Goes through the file once. Errors: File::open's, kIoFailure.
  [[nodiscard]] virtual Result<ContainerInfo> survey() const = 0;
};

}  // namespace pled::replay
