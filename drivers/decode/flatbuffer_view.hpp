#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

namespace pled {

/// A little-endian number at `offset`; nothing when it does not lie inside.
template <typename T>
[[nodiscard]] std::optional<T> read_little_endian(std::span<const std::byte> bytes,
                                                  std::size_t offset) noexcept {
  static_assert(std::endian::native == std::endian::little && std::is_trivially_copyable_v<T>);
  if (offset > bytes.size() || bytes.size() - offset < sizeof(T)) return std::nullopt;
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

class FlatVector;

/// A table of a FlatBuffer (flatbuffers.dev, "Internals"). The bytes may be anybody's:
/// each offset is followed only after it was found to point inside them, and one that does
/// not gives nothing. A field that is absent has its default. Reads nothing in advance,
/// allocates nothing; the bytes must outlive it.
class FlatTable {
 public:
  /// The root table of a buffer with this four-letter identifier.
  [[nodiscard]] static std::optional<FlatTable> root(std::span<const std::byte> buffer,
                                                     std::string_view identifier) noexcept;
  /// The same where a 32-bit length stands in front; bytes behind that length are ignored.
  [[nodiscard]] static std::optional<FlatTable> size_prefixed_root(
      std::span<const std::byte> bytes, std::string_view identifier) noexcept;

  /// The number in a field, or `otherwise` when the field is absent.
  template <typename T>
  [[nodiscard]] std::optional<T> number(unsigned field, T otherwise) const noexcept {
    const std::size_t offset = offset_of(field);
    if (offset == 0) return otherwise;
    return read_little_endian<T>(buffer_.subspan(at_, table_bytes_), offset);
  }
  /// The vector that a field points to, empty when the field is absent. Each element takes
  /// `element_bytes`, and all of them lie inside the buffer.
  [[nodiscard]] std::optional<FlatVector> vector(unsigned field,
                                                 std::size_t element_bytes) const noexcept;

 private:
  friend class FlatVector;
  FlatTable() = default;

  [[nodiscard]] static std::optional<FlatTable> at(std::span<const std::byte> buffer,
                                                   std::size_t position) noexcept;
  /// Where a field begins, counted from the table; 0 when it is absent.
  [[nodiscard]] std::size_t offset_of(unsigned field) const noexcept;

  std::span<const std::byte> buffer_;
  std::size_t at_ = 0;           ///< of the table
  std::size_t table_bytes_ = 0;  ///< its inline part, which lies inside the buffer
  std::size_t vtable_at_ = 0;
  std::size_t vtable_bytes_ = 0;
};

/// A vector of a FlatBuffer; its elements lie inside the buffer.
class FlatVector {
 public:
  FlatVector() = default;

  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  /// The elements, one behind the other.
  [[nodiscard]] std::span<const std::byte> bytes() const noexcept {
    return buffer_.subspan(at_, count_ * element_bytes_);
  }
  /// The table that element `index` < size() of a vector of tables points to.
  [[nodiscard]] std::optional<FlatTable> table(std::size_t index) const noexcept;

 private:
  friend class FlatTable;

  std::span<const std::byte> buffer_;
  std::size_t at_ = 0;  ///< of the first element
  std::size_t count_ = 0;
  std::size_t element_bytes_ = 0;
};

}  // namespace pled
