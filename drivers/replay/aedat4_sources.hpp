#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "drivers/decode/aedat4_packets.hpp"
#include "drivers/replay/aedat4_reader.hpp"
#include "drivers/replay/frame_slots.hpp"
#include "drivers/replay/recorded_source.hpp"

namespace pled::replay {

/// The events of one stream of an AEDAT 4.0 file, as Aedat4EventDecoder takes them. A packet
/// that cannot be read is counted and skipped; the next chunk then says after_gap. Chunks of
/// one packet may be held at the same time; a further acquire() says kTimeout.
class Aedat4EventSource final : public RecordedEventSource {
 public:
  Aedat4EventSource(Aedat4Reader reader, std::int32_t stream);

  /// Goes back to the beginning.
  Result<void> start() noexcept override;
  /// Errors: kEndOfStream, kTimeout, kIoFailure (final).
  Result<RawChunk> acquire(Duration timeout) noexcept override;
  void release() noexcept override;
  void stop() noexcept override { running_ = false; }

  [[nodiscard]] std::int64_t position() const noexcept override { return reader_.position(); }
  [[nodiscard]] std::int64_t size() const noexcept override { return reader_.size(); }
  [[nodiscard]] std::uint64_t lost_packets() const noexcept override { return lost_; }

 private:
  [[nodiscard]] Result<void> load() noexcept;

  Aedat4Reader reader_;
  std::int32_t stream_;
  std::span<const std::byte> rest_;  ///< of the packet
  std::size_t held_ = 0;
  std::uint64_t lost_ = 0;
  bool after_gap_ = false;
  bool running_ = false;
};

/// The inertial samples of one stream of an AEDAT 4.0 file: rad/s and m/s^2 on the axes that
/// the file has. Stamps are passed on as they are.
class Aedat4ImuSource final : public RecordedImuSource {
 public:
  Aedat4ImuSource(Aedat4Reader reader, std::int32_t stream);

  Result<void> start() noexcept override { return {}; }
  /// Errors: kEndOfStream, kIoFailure, kBadNumber (a packet or a sample that does not read;
  /// counted, call again).
  Result<ImuSample> read(Duration timeout) noexcept override;
  void stop() noexcept override {}

  [[nodiscard]] std::uint64_t malformed() const noexcept override { return malformed_; }
  [[nodiscard]] std::string_view last_message() const noexcept override {
    return reader_.last_message();
  }
  [[nodiscard]] double progress() const noexcept override { return reader_.progress(); }

 private:
  [[nodiscard]] Result<void> load() noexcept;
  [[nodiscard]] Error bad(const char* what) noexcept;

  Aedat4Reader reader_;
  std::int32_t stream_;
  Aedat4ImuPacket packet_;
  std::size_t next_ = 0;  ///< sample of the packet
  std::uint64_t malformed_ = 0;
};

/// The frames of one stream of an AEDAT 4.0 file as 8-bit grey, stamped at mid-exposure.
class Aedat4FrameSource final : public RecordedFrameSource {
 public:
  Aedat4FrameSource(Aedat4Reader reader, std::int32_t stream, FrameSlots::Options options);

  Result<void> start() noexcept override { return {}; }
  /// Errors: kCorrupt (a packet that does not read, or of another size; counted, call again),
  /// kTimeout (every slot is held), kEndOfStream, kIoFailure (final). Frames whose stamp is
  /// not later than the last are skipped and counted.
  Result<FrameView> acquire(Duration timeout) noexcept override;
  void release() noexcept override { slots_.release(); }
  void stop() noexcept override {}

  [[nodiscard]] FrameFaults faults() const noexcept override { return slots_.faults(); }
  [[nodiscard]] std::string_view last_message() const noexcept override;
  [[nodiscard]] double progress() const noexcept override { return reader_.progress(); }

 private:
  [[nodiscard]] Error lost(const char* what) noexcept;

  Aedat4Reader reader_;
  std::int32_t stream_;
  FrameSlots slots_;
};

}  // namespace pled::replay
