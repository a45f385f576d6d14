#include "drivers/decode/flatbuffer_view.hpp"

namespace pled {
namespace {

/// A vtable begins with its own length and that of the table's inline part.
constexpr std::size_t kVtableHead = 4;
constexpr std::size_t kIdentifierAt = 4;

/// Where the 32-bit offset at `position` points to: forward, inside the buffer.
[[nodiscard]] std::optional<std::size_t> target_of(std::span<const std::byte> buffer,
                                                   std::size_t position) noexcept {
  const auto offset = read_little_endian<std::uint32_t>(buffer, position);
  if (!offset || *offset == 0 || *offset >= buffer.size() - position) return std::nullopt;
  return position + *offset;
}

}  // namespace

std::optional<FlatTable> FlatTable::root(std::span<const std::byte> buffer,
                                         std::string_view identifier) noexcept {
  const auto position = target_of(buffer, 0);
  if (!position || buffer.size() < kIdentifierAt + identifier.size()) return std::nullopt;
  if (std::memcmp(buffer.data() + kIdentifierAt, identifier.data(), identifier.size()) != 0)
    return std::nullopt;
  return at(buffer, *position);
}

std::optional<FlatTable> FlatTable::size_prefixed_root(std::span<const std::byte> bytes,
                                                       std::string_view identifier) noexcept {
  const auto size = read_little_endian<std::uint32_t>(bytes, 0);
  if (!size || *size > bytes.size() - sizeof(*size)) return std::nullopt;
  return root(bytes.subspan(sizeof(*size), *size), identifier);
}

std::optional<FlatTable> FlatTable::at(std::span<const std::byte> buffer,
                                       std::size_t position) noexcept {
  const auto to_vtable = read_little_endian<std::int32_t>(buffer, position);
  if (!to_vtable) return std::nullopt;
  const std::int64_t vtable_at = static_cast<std::int64_t>(position) - *to_vtable;
  if (vtable_at < 0) return std::nullopt;
  FlatTable table;
  table.buffer_ = buffer;
  table.at_ = position;
  table.vtable_at_ = static_cast<std::size_t>(vtable_at);
  const auto vtable_bytes = read_little_endian<std::uint16_t>(buffer, table.vtable_at_);
  const auto table_bytes = read_little_endian<std::uint16_t>(buffer, table.vtable_at_ + 2);
  if (!vtable_bytes || !table_bytes || *vtable_bytes < kVtableHead) return std::nullopt;
  table.vtable_bytes_ = *vtable_bytes;
  table.table_bytes_ = *table_bytes;
  if (table.vtable_bytes_ > buffer.size() - table.vtable_at_) return std::nullopt;
  if (table.table_bytes_ > buffer.size() - position) return std::nullopt;
  return table;
}

std::size_t FlatTable::offset_of(unsigned field) const noexcept {
  const std::size_t entry = kVtableHead + std::size_t{field} * 2;
  return read_little_endian<std::uint16_t>(buffer_.subspan(vtable_at_, vtable_bytes_), entry)
      .value_or(0);
}

std::optional<FlatVector> FlatTable::vector(unsigned field,
                                            std::size_t element_bytes) const noexcept {
  const std::size_t offset = offset_of(field);
  if (offset == 0) return FlatVector{};
  if (offset >= table_bytes_) return std::nullopt;
  const auto position = target_of(buffer_, at_ + offset);
  if (!position) return std::nullopt;
  const auto count = read_little_endian<std::uint32_t>(buffer_, *position);
  if (!count) return std::nullopt;
  FlatVector vector;
  vector.buffer_ = buffer_;
  vector.at_ = *position + sizeof(*count);
  vector.count_ = *count;
  vector.element_bytes_ = element_bytes;
  if (vector.count_ > (buffer_.size() - vector.at_) / element_bytes) return std::nullopt;
  return vector;
}

std::optional<FlatTable> FlatVector::table(std::size_t index) const noexcept {
  const auto position = target_of(buffer_, at_ + index * element_bytes_);
  if (!position) return std::nullopt;
  return FlatTable::at(buffer_, *position);
}

}  // namespace pled
