#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "drivers/decode/flatbuffer_view.hpp"
#include "pled_vins/core/messages.hpp"

/// The packets of AEDAT 4.0: FlatBuffers with their length in front, unpacked. Whatever the
/// bytes are, a packet that is not as its kind says gives nothing. A field at its default is
/// absent from the file and read as zero.
namespace pled {

/// Stamps beyond this cannot be told in nanoseconds and are no stamps.
inline constexpr std::int64_t kMaxAedat4Stamp_us =
    std::numeric_limits<std::int64_t>::max() / 1000 - 1;

/// Bytes of one event: i64 t_us, i16 x, i16 y, u8 polarity, 3 unused.
inline constexpr std::size_t kAedat4EventBytes = 16;

/// The events of an EVTS packet, kAedat4EventBytes each, for Aedat4EventDecoder.
[[nodiscard]] std::optional<std::span<const std::byte>> aedat4_events(
    std::span<const std::byte> packet) noexcept;

/// An IMUS packet.
class Aedat4ImuPacket {
 public:
  Aedat4ImuPacket() = default;
  [[nodiscard]] static std::optional<Aedat4ImuPacket> read(
      std::span<const std::byte> packet) noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return samples_.size(); }
  /// Sample `index` < size(); nothing when it cannot be read or is not finite. The file has
  /// degrees per second and g (taken as 9.80665 m/s^2); the axes are the file's own.
  [[nodiscard]] std::optional<ImuSample> sample(std::size_t index) const noexcept;

 private:
  FlatVector samples_;
};

/// The layout of a frame's pixels, in the numbers of the file (OpenCV's).
enum class Aedat4PixelFormat : std::int8_t { kGrey = 0, kBgr = 16, kBgra = 24 };

/// A FRME packet. The pixels are those of the packet, row by row, without gaps.
struct Aedat4Frame {
  std::int64_t t_us = 0;  ///< middle of the exposure, else the stamp of the frame
  Aedat4PixelFormat format = Aedat4PixelFormat::kGrey;
  int width_px = 0;
  int height_px = 0;
  std::span<const std::byte> pixels;
};
/// Nothing also for a format that is none of the three, and when the number of pixels is
/// not that of the size.
[[nodiscard]] std::optional<Aedat4Frame> aedat4_frame(std::span<const std::byte> packet) noexcept;

/// How many triggers a TRIG packet holds.
[[nodiscard]] std::optional<std::size_t> aedat4_trigger_count(
    std::span<const std::byte> packet) noexcept;

/// How many packets the table at the end of a file (FTAB) lists.
[[nodiscard]] std::optional<std::size_t> aedat4_table_size(
    std::span<const std::byte> packet) noexcept;

}  // namespace pled
