#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/replay/decompressor.hpp"
#include "drivers/replay/image_codec.hpp"
#include "pled_vins/core/result.hpp"

namespace pled::replay {

inline constexpr std::string_view kAedat4Mark = "#!AER-DAT4.0\r\n";

/// One stream of an AEDAT 4.0 file. A size that is not told is zero.
struct Aedat4Stream {
  std::int32_t id = 0;
  std::string type;  ///< EVTS, FRME, IMUS, TRIG or another
  ImageSize size;
};

/// What the head of an AEDAT 4.0 file says.
struct Aedat4Header {
  std::int32_t compression = 0;      ///< as in the file, see compression_of()
  std::int64_t packets_begin = 0;    ///< byte of the file
  std::int64_t table_position = -1;  ///< of the table of packets; -1: there is none
  std::vector<Aedat4Stream> streams;

  /// The stream of this type with the smallest number; nullptr when there is none.
  [[nodiscard]] const Aedat4Stream* first(std::string_view type) const noexcept;
};

/// Reads the head of a file: the mark, the header's length and an IOHE FlatBuffer with a
/// description of the streams in XML, of which the types (typeIdentifier) and sizes (sizeX,
/// sizeY) are read. Errors: File::open's, kTruncated, kCorrupt.
[[nodiscard]] Result<Aedat4Header> read_aedat4_header(const char* path);

/// Parses the bytes behind the mark, the length first.
[[nodiscard]] Result<Aedat4Header> parse_aedat4_header(std::span<const std::byte> bytes);

/// Compression 0 is none, 1 and 2 are LZ4, 3 and 4 Zstandard. Errors: kUnsupported.
[[nodiscard]] Result<Compression> compression_of(std::int32_t number) noexcept;

}  // namespace pled::replay
