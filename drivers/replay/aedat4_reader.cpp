#include "drivers/replay/aedat4_reader.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "drivers/decode/aedat4_packets.hpp"

namespace pled::replay {
namespace {

constexpr std::int64_t kPacketHeadBytes = 8;  ///< stream and length

}  // namespace

Result<Aedat4Reader> Aedat4Reader::open(const std::string& path, const Aedat4Header& header) {
  const auto compression = compression_of(header.compression);
  if (!compression.ok()) return compression.error();
  auto decompressor = Decompressor::create(compression.value());
  if (!decompressor.ok()) return decompressor.error();
  auto file = File::open(path.c_str());
  if (!file.ok()) return file.error();
  return Aedat4Reader(std::move(file).value(), path, header, compression.value(),
                      std::move(decompressor).value());
}

Aedat4Reader::Aedat4Reader(File file, const std::string& path, const Aedat4Header& header,
                           Compression compression, Decompressor decompressor)
    : file_(std::move(file)),
      path_(path),
      decompressor_(std::move(decompressor)),
      packed_bytes_(static_cast<std::size_t>(
          std::min(file_.size(), static_cast<std::int64_t>(kMaxPacketBytes)))),
      plain_bytes_(compression == Compression::kNone ? packed_bytes_ : kMaxPacketBytes),
      packed_(std::make_unique_for_overwrite<std::byte[]>(packed_bytes_)),
      plain_(std::make_unique_for_overwrite<std::byte[]>(plain_bytes_)),
      begin_(header.packets_begin),
      end_(std::max(begin_, file_.size())) {
  for (const Aedat4Stream& stream : header.streams) streams_.push_back(stream.id);
  look_at_table(header.table_position);
  rewind();
}

void Aedat4Reader::look_at_table(std::int64_t position) noexcept {
  if (position < begin_ || position >= file_.size()) return;
  const auto table = read(position, file_.size() - position);
  if (!table.ok()) return;
  const auto packets = aedat4_table_size(table.value());
  if (!packets) return;
  listed_packets_ = static_cast<std::int64_t>(*packets);
  end_ = position;
}

void Aedat4Reader::rewind() noexcept {
  next_at_ = begin_;
  bytes_ = 0;
  is_cut_ = false;
  message_.set("");
}

Result<std::int32_t> Aedat4Reader::next() noexcept {
  if (is_cut_ || next_at_ >= end_) return ErrorCode::kEndOfStream;
  std::array<std::byte, kPacketHeadBytes> head{};
  PLED_TRY(file_.seek(next_at_));
  const auto got = file_.read(head);
  if (!got.ok()) return got.error();
  const auto stream = *read_little_endian<std::int32_t>(head, 0);
  const auto bytes = *read_little_endian<std::int32_t>(head, sizeof(stream));
  const std::int64_t at = next_at_ + kPacketHeadBytes;
  const bool is_whole = got.value() == head.size() && at <= end_;
  if (is_whole && is_known(stream) && bytes >= 0 && bytes <= end_ - at) {
    at_ = at;
    bytes_ = bytes;
    next_at_ = at + bytes;
    return stream;
  }
  is_cut_ = true;
  const bool is_packet = !is_whole || (is_known(stream) && bytes >= 0);
  message_.set(is_packet ? "%s: the packet at byte %lld is cut; nothing follows it"
                         : "%s: no packet begins at byte %lld; the rest cannot be read",
               path_.c_str(), static_cast<long long>(next_at_));
  return ErrorCode::kEndOfStream;
}

Result<std::span<const std::byte>> Aedat4Reader::payload() noexcept {
  const auto plain = read(at_, bytes_);
  if (!plain.ok()) {
    const std::string_view why = to_string(plain.error().code);
    message_.set("%s: the packet at byte %lld cannot be unpacked: %.*s; it was skipped",
                 path_.c_str(), static_cast<long long>(at_ - kPacketHeadBytes),
                 static_cast<int>(why.size()), why.data());
  }
  return plain;
}

Result<std::span<const std::byte>> Aedat4Reader::read(std::int64_t at,
                                                      std::int64_t bytes) noexcept {
  const auto wanted = static_cast<std::size_t>(bytes);
  if (wanted > packed_bytes_) return ErrorCode::kTooLarge;
  PLED_TRY(file_.seek(at));
  const auto got = file_.read({packed_.get(), wanted});
  if (!got.ok()) return got.error();
  if (got.value() < wanted) return ErrorCode::kTruncated;
  const auto size = decompressor_.decompress({packed_.get(), wanted}, {plain_.get(), plain_bytes_});
  if (!size.ok()) return size.error();
  return std::span<const std::byte>{plain_.get(), size.value()};
}

void Aedat4Reader::blame(const char* what) noexcept {
  message_.set("%s: the packet at byte %lld %s; it was skipped", path_.c_str(),
               static_cast<long long>(at_ - kPacketHeadBytes), what);
}

bool Aedat4Reader::is_known(std::int32_t stream) const noexcept {
  return std::find(streams_.begin(), streams_.end(), stream) != streams_.end();
}

double Aedat4Reader::progress() const noexcept {
  if (size() <= 0) return 1.0;
  return static_cast<double>(position()) / static_cast<double>(size());
}

}  // namespace pled::replay
