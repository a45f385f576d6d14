#include "drivers/replay/aedat4_header.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

#include "drivers/decode/decimal.hpp"
#include "drivers/decode/flatbuffer_view.hpp"
#include "drivers/replay/file.hpp"

namespace pled::replay {
namespace {

constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20;  // those seen have 3 KB
constexpr std::size_t kMaxStreams = 64;
constexpr std::size_t kMaxDepth = 32;
constexpr int kMaxSide = 16'384;

/// The value of ` name="value"` in a tag; empty when it has none.
[[nodiscard]] std::string_view attribute(std::string_view tag, std::string_view name) {
  for (std::size_t at = tag.find(name); at != std::string_view::npos; at = tag.find(name, at + 1)) {
    const std::string_view rest = tag.substr(at + name.size());
    const bool is_word = at > 0 && (tag[at - 1] == ' ' || tag[at - 1] == '\t');
    if (!is_word || !rest.starts_with("=\"")) continue;
    return rest.substr(2, rest.find('"', 2) - 2);
  }
  return {};
}

/// Goes through the tags `node` and `attr` of the description, and keeps what lies in
/// outInfo/<id> and outInfo/<id>/info.
class StreamList {
 public:
  [[nodiscard]] std::vector<Aedat4Stream> read(std::string_view xml) {
    while (true) {
      const std::size_t begin = xml.find('<');
      const std::size_t end = begin == std::string_view::npos ? begin : xml.find('>', begin);
      if (end == std::string_view::npos) break;
      const std::string_view tag = xml.substr(begin + 1, end - begin - 1);
      xml.remove_prefix(end + 1);
      take(tag, xml.substr(0, xml.find('<')));
    }
    const auto by_id = [](const Aedat4Stream& a, const Aedat4Stream& b) { return a.id < b.id; };
    std::sort(streams_.begin(), streams_.end(), by_id);
    return std::move(streams_);
  }

 private:
  void take(std::string_view tag, std::string_view text) {
    if (tag.starts_with("/node")) {
      if (!path_.empty()) path_.pop_back();
    } else if (tag.starts_with("node")) {
      if (!tag.ends_with('/') && path_.size() < kMaxDepth) path_.push_back(attribute(tag, "name"));
    } else if (tag.starts_with("attr")) {
      take_value(attribute(tag, "key"), text);
    }
  }

  void take_value(std::string_view key, std::string_view value) {
    const std::size_t depth = path_.size();
    const bool in_info = depth >= 3 && path_[depth - 1] == "info" && path_[depth - 3] == "outInfo";
    const bool in_stream = depth >= 2 && path_[depth - 2] == "outInfo";
    if (!in_info && !in_stream) return;
    Aedat4Stream* const stream = stream_named(path_[in_info ? depth - 2 : depth - 1]);
    if (stream == nullptr) return;
    if (in_stream && key == "typeIdentifier") stream->type = value;
    if (in_info && key == "sizeX") stream->size.width_px = side(value);
    if (in_info && key == "sizeY") stream->size.height_px = side(value);
  }

  [[nodiscard]] Aedat4Stream* stream_named(std::string_view name) {
    const std::optional<int> id = parse_int(name);
    if (!id || *id < 0) return nullptr;
    const auto found = std::find_if(streams_.begin(), streams_.end(),
                                    [&](const Aedat4Stream& stream) { return stream.id == *id; });
    if (found != streams_.end()) return &*found;
    if (streams_.size() == kMaxStreams) return nullptr;
    return &streams_.emplace_back(Aedat4Stream{*id, {}, {}});
  }

  [[nodiscard]] static int side(std::string_view text) {
    const std::optional<int> value = parse_int(text);
    return value && *value > 0 && *value <= kMaxSide ? *value : 0;
  }

  std::vector<std::string_view> path_;
  std::vector<Aedat4Stream> streams_;
};

}  // namespace

const Aedat4Stream* Aedat4Header::first(std::string_view type) const noexcept {
  const auto found = std::find_if(streams.begin(), streams.end(),
                                  [&](const Aedat4Stream& stream) { return stream.type == type; });
  return found == streams.end() ? nullptr : &*found;
}

Result<Aedat4Header> parse_aedat4_header(std::span<const std::byte> bytes) {
  enum Field : unsigned { kCompression, kTablePosition, kDescription };
  const auto length = read_little_endian<std::uint32_t>(bytes, 0);
  if (!length) return ErrorCode::kTruncated;
  if (*length > kMaxHeaderBytes) return ErrorCode::kCorrupt;
  if (*length > bytes.size() - sizeof(*length)) return ErrorCode::kTruncated;
  const auto root = FlatTable::size_prefixed_root(bytes, "IOHE");
  if (!root) return ErrorCode::kCorrupt;
  const auto compression = root->number<std::int32_t>(kCompression, 0);
  const auto table = root->number<std::int64_t>(kTablePosition, -1);
  const auto text = root->vector(kDescription, 1);
  if (!compression || !table || !text) return ErrorCode::kCorrupt;
  Aedat4Header header;
  header.compression = *compression;
  header.table_position = *table;
  header.packets_begin = static_cast<std::int64_t>(kAedat4Mark.size() + sizeof(*length) + *length);
  const std::span<const std::byte> xml = text->bytes();
  header.streams = StreamList().read({reinterpret_cast<const char*>(xml.data()), xml.size()});
  return header;
}

Result<Aedat4Header> read_aedat4_header(const char* path) {
  auto file = File::open(path);
  if (!file.ok()) return file.error();
  const std::int64_t most = static_cast<std::int64_t>(kAedat4Mark.size() + 4 + kMaxHeaderBytes);
  std::vector<std::byte> head(static_cast<std::size_t>(std::min(file.value().size(), most)));
  const auto got = file.value().read(head);
  if (!got.ok()) return got.error();
  head.resize(got.value());
  const std::size_t mark = std::min(head.size(), kAedat4Mark.size());
  if (std::memcmp(head.data(), kAedat4Mark.data(), mark) != 0) return ErrorCode::kCorrupt;
  if (mark < kAedat4Mark.size()) return ErrorCode::kTruncated;
  return parse_aedat4_header(std::span<const std::byte>(head).subspan(mark));
}

Result<Compression> compression_of(std::int32_t number) noexcept {
  switch (number) {
    case 0: return Compression::kNone;
    case 1:
    case 2: return Compression::kLz4;
    case 3:
    case 4: return Compression::kZstd;
    default: return ErrorCode::kUnsupported;
  }
}

}  // namespace pled::replay
