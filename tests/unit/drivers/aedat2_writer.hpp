#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// Writes AEDAT 2.0 records of a DAVIS for tests, by name.
namespace pled::support {

struct Pair {
  std::uint32_t address = 0;
  std::uint32_t stamp = 0;
};
using Pairs = std::vector<Pair>;

/// x and y as the file counts them, from the lower right corner.
[[nodiscard]] constexpr std::uint32_t dvs(unsigned x, unsigned y, bool on) {
  return y << 22 | x << 12 | (on ? 1U << 11 : 0U);
}
[[nodiscard]] constexpr std::uint32_t special(unsigned bits = 0) { return 1U << 10 | bits << 12; }
/// x from the left, y from below.
[[nodiscard]] constexpr std::uint32_t reset_read(unsigned x, unsigned y, unsigned sample) {
  return 1U << 31 | y << 22 | x << 12 | sample;
}
[[nodiscard]] constexpr std::uint32_t signal_read(unsigned x, unsigned y, unsigned sample) {
  return reset_read(x, y, sample) | 1U << 10;
}
[[nodiscard]] constexpr std::uint32_t imu_word(unsigned code, int value) {
  return 1U << 31 | code << 28 | static_cast<std::uint32_t>(value & 0xFFFF) << 12 | 3U << 10;
}

/// ax ay az temperature gx gy gz with one stamp.
inline void add_imu(Pairs& pairs, std::uint32_t stamp, std::array<int, 7> words) {
  for (unsigned code = 0; code < words.size(); ++code)
    pairs.push_back({imu_word(code, words[code]), stamp});
}

[[nodiscard]] inline std::vector<std::byte> wire(const Pairs& pairs) {
  std::vector<std::byte> bytes;
  for (const Pair& pair : pairs)
    for (const std::uint32_t word : {pair.address, pair.stamp})
      for (const unsigned shift : {24U, 16U, 8U, 0U})
        bytes.push_back(static_cast<std::byte>(word >> shift & 0xFFU));
  return bytes;
}

inline const std::string kAedat2Head =
    "#!AER-DAT2.0\r\n# This is a raw AE data file - do not edit\r\n"
    "# AEChip: eu.seebetter.ini.chips.davis.DAVIS240C\r\n"
    "#  <entry key=\"ImuGyroScale\" value=\"GyroFullScaleDegPerSec1000\"/>\r\n"
    "#  <entry key=\"ImuAccelScale\" value=\"ImuAccelScaleG8\"/>\r\n";

/// A whole file.
[[nodiscard]] inline std::vector<std::byte> aedat2_file(const std::string& head,
                                                        const Pairs& pairs) {
  std::vector<std::byte> bytes;
  for (const char c : head) bytes.push_back(static_cast<std::byte>(c));
  const std::vector<std::byte> records = wire(pairs);
  bytes.insert(bytes.end(), records.begin(), records.end());
  return bytes;
}

}  // namespace pled::support
