#pragma once

#include <cstddef>
#include <span>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/core/result.hpp"

namespace pled {

/// Raw bytes of an event camera, as the wire or the file had them.
struct RawChunk {
  std::span<const std::byte> bytes;  ///< the source's memory, valid until release()
  Timestamp received;                ///< host clock at arrival; recordings: zero
  bool after_gap = false;            ///< bytes were lost just before: decoders resynchronise
};

/// Raw event-camera bytes in order, from a device, a recording or a script.
/// One reader thread.
class EventSource {
 public:
  virtual ~EventSource() = default;
  /// Begins streaming. Errors: kDisconnected, kIoFailure.
  virtual Result<void> start() noexcept = 0;
  /// Waits for the next chunk, oldest first. Never allocates. Errors: kTimeout
  /// (call again), kDisconnected, kEndOfStream (final; recordings only).
  virtual Result<RawChunk> acquire(Duration timeout) noexcept = 0;
  /// Gives back the oldest acquired chunk.
  virtual void release() noexcept = 0;
  /// Ends streaming; acquired chunks stay valid. Idempotent.
  virtual void stop() noexcept = 0;
};

/// What a decoder met that was not as its format says. Every loss is counted.
struct DecoderFaults {
  std::uint64_t outside_sensor = 0;  ///< events whose pixel is not on the sensor, dropped
  std::uint64_t time_backwards = 0;  ///< stamps below the last one, held at the last one
  std::uint64_t malformed = 0;       ///< words or lines that are none of the format's
  std::uint64_t before_sync = 0;     ///< words skipped before the first full time or row
  std::uint64_t gaps = 0;            ///< chunks marked after_gap, time jumps
};

struct DecodeStep {
  std::size_t bytes_consumed = 0;  ///< less than given only when `out` has no more room
  std::size_t events = 0;          ///< written to the front of `out`
};

/// Bytes of one wire format to events. Keeps its state across chunks, never allocates, never gives
/// an event outside the sensor, or a decreasing time but where a clock was set back by over 2 s.
class EventDecoder {
 public:
  /// `out` must hold at least this many, so that every call makes progress.
  static constexpr std::size_t kMinOutput = 64;

  virtual ~EventDecoder() = default;
  /// Call again with the rest of the bytes until all are consumed.
  virtual DecodeStep decode(std::span<const std::byte> bytes, std::span<Event> out) noexcept = 0;
  /// Bytes were lost: forget partial words and positions, keep the time base.
  virtual void resynchronise() noexcept = 0;
  /// No byte follows: a word or line that was cut off is malformed.
  virtual void finish() noexcept = 0;
  [[nodiscard]] virtual const DecoderFaults& faults() const noexcept = 0;
};

}  // namespace pled
