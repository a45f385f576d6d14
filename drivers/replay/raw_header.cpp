#include "drivers/replay/raw_header.hpp"

#include <algorithm>
#include <string_view>

#include "drivers/decode/decimal.hpp"
#include "drivers/replay/file.hpp"

namespace pled::replay {
namespace {

/// A side of a sensor: 1..2048, the address space of the encodings.
[[nodiscard]] bool read_side(std::string_view text, int& out) noexcept {
  constexpr int kMaxSide = 2048;
  const auto value = parse_int(text);
  if (!value || *value < 1 || *value > kMaxSide) return false;
  out = *value;
  return true;
}

[[nodiscard]] RawFormat format_named(std::string_view name) noexcept {
  if (name == "EVT3" || name == "3.0") return RawFormat::kEvt3;
  if (name == "EVT21" || name == "2.1") return RawFormat::kEvt21;
  if (name == "EVT2" || name == "2.0") return RawFormat::kEvt2;
  return RawFormat::kUnknown;
}

/// `EVT3;height=720;width=1280`
[[nodiscard]] bool read_format(std::string_view text, RawHeader& header) noexcept {
  const auto next_part = [&text] {
    const std::size_t cut = std::min(text.find(';'), text.size());
    const std::string_view part = text.substr(0, cut);
    text.remove_prefix(std::min(cut + 1, text.size()));
    return part;
  };
  header.format = format_named(next_part());
  while (!text.empty()) {
    const std::string_view option = next_part();
    if (option.starts_with("width=") && !read_side(option.substr(6), header.width_px)) return false;
    if (option.starts_with("height=") && !read_side(option.substr(7), header.height_px)) {
      return false;
    }
  }
  return true;
}

/// `1280x720`
[[nodiscard]] bool read_geometry(std::string_view text, RawHeader& header) noexcept {
  const std::size_t cut = text.find('x');
  if (cut == std::string_view::npos) return false;
  return read_side(text.substr(0, cut), header.width_px) &&
         read_side(text.substr(cut + 1), header.height_px);
}

[[nodiscard]] bool read_entry(std::string_view entry, RawHeader& header) noexcept {
  const std::string_view key = next_field(entry);
  if (key == "format") return read_format(next_field(entry), header);
  if (key == "geometry") return read_geometry(next_field(entry), header);
  if (key == "evt" && header.format == RawFormat::kUnknown) {
    header.format = format_named(next_field(entry));
  }
  return true;
}

[[nodiscard]] bool is_text(std::string_view line) noexcept {
  return std::all_of(line.begin(), line.end(), [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return code == '\t' || code == '\r' || (code >= 0x20 && code != 0x7F);
  });
}

}  // namespace

Result<RawHeader> parse_raw_header(std::span<const std::byte> head) noexcept {
  const std::string_view text{reinterpret_cast<const char*>(head.data()), head.size()};
  RawHeader header;
  std::int64_t line_number = 0;
  while (true) {
    const std::string_view rest = text.substr(header.bytes);
    const std::size_t end = rest.find('\n');
    // Words may begin with the bytes of "% ": only a line of text belongs to the header.
    if (!rest.starts_with('%') || end == std::string_view::npos) return header;
    std::string_view line = rest.substr(0, end);
    if (!is_text(line)) return header;
    header.bytes += end + 1;
    ++line_number;
    line = trimmed_line(line.substr(1));
    std::string_view words = line;
    if (next_field(words) == "end" && words.empty()) return header;
    if (!read_entry(line, header)) return Error{ErrorCode::kCorrupt, line_number};
  }
}

Result<RawHeader> read_raw_header(const char* path) {
  const auto head = read_head(path);
  if (!head.ok()) return head.error();
  return parse_raw_header(head.value());
}

Result<std::vector<std::byte>> read_head(const char* path) {
  auto file = File::open(path);
  if (!file.ok()) return file.error();
  std::vector<std::byte> head(kMaxRawHeaderBytes);
  const auto got = file.value().read(head);
  if (!got.ok()) return got.error();
  head.resize(got.value());
  return head;
}

}  // namespace pled::replay
