#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "pled_vins/core/result.hpp"

namespace pled::replay {

enum class Compression : std::uint8_t { kNone, kLz4, kZstd };

namespace detail {
/// Gives a library's memory back to it.
struct ByLibrary {
  void (*free)(void*) noexcept = nullptr;
  void operator()(void* context) const noexcept { free(context); }
};
}  // namespace detail

/// Unpacks LZ4 and Zstandard frames, as far as this build has their libraries.
class Decompressor {
 public:
  /// Errors: kUnsupported when the library was not there when this was built (missing_package()
  /// names it), kTooLarge when it has no memory.
  [[nodiscard]] static Result<Decompressor> create(Compression compression) noexcept;
  /// The Debian package that a build for this compression needs.
  [[nodiscard]] static const char* missing_package(Compression compression) noexcept;

  /// Unpacks one whole frame into the front of `out`, and says how long it is. Errors:
  /// kCorrupt (no such frame, or more than it), kTruncated, kTooLarge (more than `out` holds).
  /// The LZ4 library keeps its block buffers, at most 5 MB, from the first frame on.
  [[nodiscard]] Result<std::size_t> decompress(std::span<const std::byte> in,
                                               std::span<std::byte> out) noexcept;

 private:
  Decompressor() = default;

  Compression compression_ = Compression::kNone;
  std::unique_ptr<void, detail::ByLibrary> context_;
};

}  // namespace pled::replay
