#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pled_vins/core/result.hpp"

namespace pled::replay {

enum class RawFormat : std::uint8_t { kUnknown, kEvt2, kEvt21, kEvt3 };

/// What the text at the head of a Prophesee RAW file says. Zero: it does not say.
struct RawHeader {
  RawFormat format = RawFormat::kUnknown;
  int width_px = 0;
  int height_px = 0;
  std::size_t bytes = 0;  ///< length of the header; the words follow
};

/// Enough of a file's beginning for every header seen.
inline constexpr std::size_t kMaxRawHeaderBytes = 16 * 1024;

/// Reads `% key value` lines up to `% end` or the first line that is none, from
/// the first bytes of a file. Keys read: `format NAME;height=H;width=W`, the
/// older `evt 3.0` and `geometry WxH`; others are skipped.
/// Errors: kCorrupt (a size that is no size), detail = line.
[[nodiscard]] Result<RawHeader> parse_raw_header(std::span<const std::byte> head) noexcept;

/// Opens, reads and parses the head of a RAW file. Errors: those and File::open's.
[[nodiscard]] Result<RawHeader> read_raw_header(const char* path);

/// The first kMaxRawHeaderBytes of a file, or all of it. Errors: File::open's, kIoFailure.
[[nodiscard]] Result<std::vector<std::byte>> read_head(const char* path);

}  // namespace pled::replay
