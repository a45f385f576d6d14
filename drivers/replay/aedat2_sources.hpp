#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/decode/aedat2_frame.hpp"
#include "drivers/decode/aedat2_imu.hpp"
#include "drivers/replay/aedat2_header.hpp"
#include "drivers/replay/file.hpp"
#include "drivers/replay/frame_slots.hpp"
#include "drivers/replay/message.hpp"
#include "drivers/replay/recorded_source.hpp"

namespace pled::replay {

/// The records of an AEDAT 2.0 file, one at a time, through one buffer of fixed size.
class Aedat2RecordFile {
 public:
  /// Errors: File::open's.
  [[nodiscard]] static Result<Aedat2RecordFile> open(const std::string& path,
                                                     const Aedat2Header& header);

  /// Errors: kEndOfStream, kIoFailure.
  [[nodiscard]] Result<Aedat2Record> next() noexcept;
  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  [[nodiscard]] double progress() const noexcept;

 private:
  static constexpr std::size_t kBufferBytes = 64 * 1024;

  Aedat2RecordFile() = default;

  File file_;
  std::string path_;
  std::unique_ptr<std::byte[]> buffer_;
  std::span<const std::byte> rest_;
  std::int64_t position_ = 0;
  bool ended_ = false;
  Aedat2Records records_;
};

/// What kinds of records an AEDAT 2.0 file holds.
struct Aedat2Census {
  bool imu = false;
  bool frames = false;  ///< reset or signal reads
  std::uint64_t special = 0;
};

/// Goes through all records once, a second for some hundred megabytes. Errors: File::open's,
/// kIoFailure.
[[nodiscard]] Result<Aedat2Census> take_census(const std::string& path, const Aedat2Header& header);

/// The inertial samples of an AEDAT 2.0 file, see Aedat2ImuCollector.
class Aedat2ImuSource final : public RecordedImuSource {
 public:
  Aedat2ImuSource(Aedat2RecordFile file, Aedat2ImuScale scale);

  Result<void> start() noexcept override { return {}; }
  /// Errors: kEndOfStream, kIoFailure, kBadNumber (a group that lacks a word; counted, call
  /// again).
  Result<ImuSample> read(Duration timeout) noexcept override;
  void stop() noexcept override {}

  [[nodiscard]] std::uint64_t malformed() const noexcept override { return told_; }
  [[nodiscard]] std::string_view last_message() const noexcept override { return message_.text(); }
  [[nodiscard]] double progress() const noexcept override { return file_.progress(); }

 private:
  [[nodiscard]] Error bad(std::int64_t t_us) noexcept;

  Aedat2RecordFile file_;
  Aedat2ImuCollector collector_;
  std::uint64_t told_ = 0;  ///< of the collector's faults
  std::int64_t last_us_ = 0;
  Message message_;
};

/// The frames of an AEDAT 2.0 file, see Aedat2FrameCollector; all have the chip's size.
class Aedat2FrameSource final : public RecordedFrameSource {
 public:
  Aedat2FrameSource(Aedat2RecordFile file, ImageSize size, std::size_t slots);

  Result<void> start() noexcept override { return {}; }
  /// Errors: kCorrupt (a frame that lacks reads; counted, call again), kTimeout (every slot is
  /// held), kEndOfStream, kIoFailure (final).
  Result<FrameView> acquire(Duration timeout) noexcept override;
  void release() noexcept override { slots_.release(); }
  void stop() noexcept override {}

  [[nodiscard]] FrameFaults faults() const noexcept override { return slots_.faults(); }
  [[nodiscard]] std::string_view last_message() const noexcept override { return message_.text(); }
  [[nodiscard]] double progress() const noexcept override { return file_.progress(); }

 private:
  Aedat2RecordFile file_;
  ImageSize size_;
  std::vector<std::uint16_t> samples_;
  Aedat2FrameCollector collector_;
  FrameSlots slots_;
  std::uint64_t told_ = 0;  ///< of the collector's faults
  Message message_;
};

}  // namespace pled::replay
