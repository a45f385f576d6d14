#include "drivers/replay/aedat2_header.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "drivers/decode/decimal.hpp"
#include "drivers/replay/file.hpp"

namespace pled::replay {
namespace {

/// Those seen have 175 KB: all the preferences of the program that wrote them.
constexpr std::size_t kMaxHeaderBytes = std::size_t{4} << 20;
constexpr std::size_t kMaxLine = 4096;

struct Chip {
  std::string_view part;  ///< of the class's name
  ImageSize size;
};
constexpr std::array kChips{Chip{"DAVIS240", {240, 180}}, Chip{"DAVIS346", {346, 260}},
                            Chip{"DAVIS640", {640, 480}}, Chip{"DAVIS128", {128, 128}},
                            Chip{"DAVIS208", {208, 192}}, Chip{"SBRET", {240, 180}}};

[[nodiscard]] std::string upper(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return out;
}

void take_chip(std::string_view name, Aedat2Header& header) {
  header.chip = name;
  const std::string_view word = name.substr(name.rfind('.') + 1);
  const std::string wanted = upper(word);
  const auto known = std::find_if(kChips.begin(), kChips.end(), [&](const Chip& chip) {
    return wanted.find(chip.part) != std::string::npos;
  });
  if (known != kChips.end()) header.size = known->size;
  header.is_davis = known != kChips.end() || wanted.find("DAVIS") != std::string::npos;
}

/// The number behind `prefix` in `key="ImuGyroScale" value="GyroFullScaleDegPerSec1000"`.
[[nodiscard]] int range_of(std::string_view line, std::string_view key, std::string_view prefix) {
  const std::size_t at = line.find(key);
  if (at == std::string_view::npos) return 0;
  line.remove_prefix(at + key.size());
  const std::size_t value = line.find(prefix);
  if (value == std::string_view::npos) return 0;
  line.remove_prefix(value + prefix.size());
  return parse_int(line.substr(0, line.find('"'))).value_or(0);
}

/// Reads the two ranges of the inertial sensor from the preferences.
class ImuRanges {
 public:
  void take(std::string_view line) {
    const int gyro = range_of(line, "\"ImuGyroScale\"", "GyroFullScaleDegPerSec");
    const int accel = range_of(line, "\"ImuAccelScale\"", "ImuAccelScaleG");
    if (is_range(gyro, 250)) gyro_degps_ = gyro;
    if (is_range(accel, 2)) accel_g_ = accel;
  }
  void give(Aedat2Header& header) const {
    constexpr double kStepsOf1000 = 32.8;  // MPU-6150: per deg/s at +-1000 deg/s
    constexpr double kStepsOf8 = 4096.0;   // per g at +-8 g
    header.imu_is_known = gyro_degps_ > 0 && accel_g_ > 0;
    if (gyro_degps_ > 0) header.imu.gyro_degps = gyro_degps_ / 1000.0 / kStepsOf1000;
    if (accel_g_ > 0) header.imu.accel_g = accel_g_ / 8.0 / kStepsOf8;
  }

 private:
  /// One of the sensor's four ranges, each twice the one before.
  static bool is_range(int value, int smallest) {
    return value == smallest || value == 2 * smallest || value == 4 * smallest ||
           value == 8 * smallest;
  }
  int gyro_degps_ = 0;
  int accel_g_ = 0;
};

/// A line that ends here and holds no control characters: records may begin with '#', too.
[[nodiscard]] bool is_text(std::string_view line) {
  return line.size() <= kMaxLine && std::all_of(line.begin(), line.end(), [](char c) {
           const auto code = static_cast<unsigned char>(c);
           return code == '\t' || code == '\r' || (code >= 0x20 && code != 0x7F);
         });
}

}  // namespace

Result<Aedat2Header> read_aedat2_header(const char* path) {
  auto file = File::open(path);
  if (!file.ok()) return file.error();
  std::vector<char> head(std::min(
      kMaxHeaderBytes, static_cast<std::size_t>(std::max<std::int64_t>(file.value().size(), 0))));
  const auto got = file.value().read(std::as_writable_bytes(std::span(head)));
  if (!got.ok()) return got.error();
  const std::string_view text{head.data(), got.value()};
  if (!text.starts_with(kAedat2Mark)) return ErrorCode::kCorrupt;
  Aedat2Header header;
  ImuRanges ranges;
  std::size_t at = 0;
  while (at < text.size() && text[at] == '#') {
    const std::size_t end = text.find('\n', at);
    if (end == std::string_view::npos) break;
    const std::string_view line = text.substr(at, end - at);
    if (!is_text(line)) break;
    at = end + 1;
    constexpr std::string_view kChip = "AEChip:";
    const std::size_t chip = line.find(kChip);
    if (header.chip.empty() && chip != std::string_view::npos) {
      std::string_view rest = trimmed_line(line.substr(chip + kChip.size()));
      take_chip(next_field(rest), header);
    }
    ranges.take(line);
    if (line.starts_with("#End Of ASCII Header")) break;
  }
  ranges.give(header);
  header.bytes = static_cast<std::int64_t>(at);
  return header;
}

}  // namespace pled::replay
