#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/decode/aedat2_records.hpp"

namespace pled {

/// Collects the reset and signal reads of a DAVIS to frames by correlated double sampling:
/// grey = (reset - signal) / 4, 0..255. Each pixel is read twice and carries its address, so
/// the order of the reads does not matter. A frame is whole when both reads of every pixel
/// are there; it is lost, and counted, when the next begins before.
///
/// The rows are counted from below in the file; columns, other than those of events, from
/// the left (jAER, DavisBaseCamera). Not verified on a real recording.
class Aedat2FrameCollector {
 public:
  /// Sides as for Aedat2EventDecoder. `samples`: width * height * 2, owned by the caller.
  Aedat2FrameCollector(int width_px, int height_px, std::span<std::uint16_t> samples) noexcept;

  /// True when `record` completes a frame: render() it before the next call.
  [[nodiscard]] bool take(const Aedat2Record& record) noexcept;
  /// Row-major from the upper left, width * height.
  void render(std::span<std::uint8_t> out) const noexcept;
  /// Middle of the exposure at the middle of the image, when the reads advance evenly. With a
  /// rolling shutter (signal reads begin before the reset reads end) that is the mean of the
  /// four ends of the reads; else the exposure lasts from the last reset to the first signal.
  [[nodiscard]] std::int64_t t_us() const noexcept;
  [[nodiscard]] std::uint64_t incomplete() const noexcept { return incomplete_; }
  /// Reads outside the sensor.
  [[nodiscard]] std::uint64_t outside() const noexcept { return outside_; }

 private:
  struct Reads {
    std::size_t count = 0;
    std::int64_t first_us = 0;
    std::int64_t last_us = 0;
    void add(std::int64_t t_us) noexcept;
  };

  void begin() noexcept;

  std::uint32_t width_px_;
  std::uint32_t height_px_;
  std::span<std::uint16_t> reset_;
  std::span<std::uint16_t> signal_;
  Reads resets_;
  Reads signals_;
  std::uint64_t incomplete_ = 0;
  std::uint64_t outside_ = 0;
};

}  // namespace pled
