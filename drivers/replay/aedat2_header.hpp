#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "drivers/decode/aedat2_imu.hpp"
#include "drivers/replay/image_codec.hpp"
#include "pled_vins/core/result.hpp"

namespace pled::replay {

inline constexpr std::string_view kAedat2Mark = "#!AER-DAT2.0";

/// What the text at the head of an AEDAT 2.0 file says.
struct Aedat2Header {
  std::int64_t bytes = 0;     ///< length of the text; the records follow
  std::string chip;           ///< `AEChip`, a Java class; empty: not told
  bool is_davis = true;       ///< false: a chip with other addresses
  ImageSize size;             ///< of a known DAVIS; else zero
  Aedat2ImuScale imu;         ///< from the preferences, else +-1000 deg/s and +-8 g
  bool imu_is_known = false;  ///< both of its ranges were told
};

/// Reads the lines that begin with '#', up to `#End Of ASCII Header` or the first line that is
/// no text. Keys read: `AEChip`, and of the preferences of jAER the entries ImuGyroScale and
/// ImuAccelScale. Errors: File::open's, kIoFailure, kCorrupt (the first line is another).
[[nodiscard]] Result<Aedat2Header> read_aedat2_header(const char* path);

}  // namespace pled::replay
