#include "drivers/decode/aedat4_packets.hpp"

#include <cmath>
#include <numbers>

namespace pled {
namespace {

constexpr std::size_t kOffsetBytes = 4;  ///< of an element of a vector of tables

[[nodiscard]] bool is_stamp(std::int64_t t_us) noexcept {
  return t_us >= -kMaxAedat4Stamp_us && t_us <= kMaxAedat4Stamp_us;
}

/// The one vector of a packet that is a list.
[[nodiscard]] std::optional<FlatVector> list_of(std::span<const std::byte> packet,
                                                std::string_view identifier,
                                                std::size_t element_bytes) noexcept {
  const auto root = FlatTable::size_prefixed_root(packet, identifier);
  if (!root) return std::nullopt;
  return root->vector(0, element_bytes);
}

[[nodiscard]] std::optional<std::size_t> size_of(const std::optional<FlatVector>& list) noexcept {
  if (!list) return std::nullopt;
  return list->size();
}

/// Bytes of a pixel; 0 for a format that there is not.
[[nodiscard]] std::size_t bytes_of_pixel(std::int8_t format) noexcept {
  switch (static_cast<Aedat4PixelFormat>(format)) {
    case Aedat4PixelFormat::kGrey: return 1;
    case Aedat4PixelFormat::kBgr: return 3;
    case Aedat4PixelFormat::kBgra: return 4;
  }
  return 0;
}

}  // namespace

std::optional<std::span<const std::byte>> aedat4_events(
    std::span<const std::byte> packet) noexcept {
  const auto list = list_of(packet, "EVTS", kAedat4EventBytes);
  if (!list) return std::nullopt;
  return list->bytes();
}

std::optional<Aedat4ImuPacket> Aedat4ImuPacket::read(std::span<const std::byte> packet) noexcept {
  const auto list = list_of(packet, "IMUS", kOffsetBytes);
  if (!list) return std::nullopt;
  Aedat4ImuPacket out;
  out.samples_ = *list;
  return out;
}

std::optional<ImuSample> Aedat4ImuPacket::sample(std::size_t index) const noexcept {
  // t, temperature, accel x y z in g, gyro x y z in deg/s, magnetometer x y z.
  constexpr unsigned kAccel = 2;
  constexpr unsigned kGyro = 5;
  constexpr double kStandardGravity_mps2 = 9.80665;
  constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
  const auto table = samples_.table(index);
  if (!table) return std::nullopt;
  const auto t_us = table->number<std::int64_t>(0, 0);
  if (!t_us || !is_stamp(*t_us)) return std::nullopt;
  ImuSample sample;
  sample.t = {*t_us};
  for (unsigned axis = 0; axis < 3; ++axis) {
    const auto accel = table->number<float>(kAccel + axis, 0.0F);
    const auto gyro = table->number<float>(kGyro + axis, 0.0F);
    if (!accel || !gyro || !std::isfinite(*accel) || !std::isfinite(*gyro)) return std::nullopt;
    sample.accel_mps2[axis] = static_cast<double>(*accel) * kStandardGravity_mps2;
    sample.gyro_radps[axis] = static_cast<double>(*gyro) * kRadiansPerDegree;
  }
  return sample;
}

std::optional<Aedat4Frame> aedat4_frame(std::span<const std::byte> packet) noexcept {
  enum Field : unsigned { kStamp = 0, kExposureBegin = 3, kExposureEnd = 4, kFormat = 5 };
  enum Shape : unsigned { kWidth = 6, kHeight = 7, kPixels = 10 };
  const auto root = FlatTable::size_prefixed_root(packet, "FRME");
  if (!root) return std::nullopt;
  const auto stamp_us = root->number<std::int64_t>(kStamp, 0);
  const auto begin_us = root->number<std::int64_t>(kExposureBegin, 0);
  const auto end_us = root->number<std::int64_t>(kExposureEnd, 0);
  const auto format = root->number<std::int8_t>(kFormat, 0);
  const auto width = root->number<std::int16_t>(kWidth, 0);
  const auto height = root->number<std::int16_t>(kHeight, 0);
  const auto pixels = root->vector(kPixels, 1);
  if (!stamp_us || !begin_us || !end_us || !format || !width || !height || !pixels)
    return std::nullopt;
  if (!is_stamp(*stamp_us) || !is_stamp(*begin_us) || !is_stamp(*end_us)) return std::nullopt;
  const std::size_t pixel_bytes = bytes_of_pixel(*format);
  if (pixel_bytes == 0 || *width <= 0 || *height <= 0) return std::nullopt;
  Aedat4Frame frame;
  frame.format = static_cast<Aedat4PixelFormat>(*format);
  frame.width_px = *width;
  frame.height_px = *height;
  frame.pixels = pixels->bytes();
  const std::size_t expected =
      static_cast<std::size_t>(*width) * static_cast<std::size_t>(*height) * pixel_bytes;
  if (frame.pixels.size() != expected) return std::nullopt;
  const bool exposure_known = *begin_us != 0 && *end_us >= *begin_us;
  frame.t_us = exposure_known ? *begin_us + (*end_us - *begin_us) / 2 : *stamp_us;
  return frame;
}

std::optional<std::size_t> aedat4_trigger_count(std::span<const std::byte> packet) noexcept {
  return size_of(list_of(packet, "TRIG", kOffsetBytes));
}

std::optional<std::size_t> aedat4_table_size(std::span<const std::byte> packet) noexcept {
  return size_of(list_of(packet, "FTAB", kOffsetBytes));
}

}  // namespace pled
