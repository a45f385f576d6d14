#include "drivers/replay/decompressor.hpp"

#include <algorithm>

#if PLED_WITH_LZ4
#include <lz4frame.h>
#endif
#if PLED_WITH_ZSTD
#include <zstd.h>
#include <zstd_errors.h>
#endif

namespace pled::replay {
namespace {

#if PLED_WITH_LZ4
[[nodiscard]] Result<std::size_t> unpack_lz4(void* context, std::span<const std::byte> in,
                                             std::span<std::byte> out) noexcept {
  auto* const lz4 = static_cast<LZ4F_dctx*>(context);
  LZ4F_resetDecompressionContext(lz4);
  std::size_t read = 0;
  std::size_t written = 0;
  while (true) {
    std::size_t taken = in.size() - read;
    std::size_t given = out.size() - written;
    const std::size_t hint =
        LZ4F_decompress(lz4, out.data() + written, &given, in.data() + read, &taken, nullptr);
    if (LZ4F_isError(hint) != 0) return ErrorCode::kCorrupt;
    read += taken;
    written += given;
    if (hint == 0) break;
    if (taken == 0 && given == 0)
      return written == out.size() ? ErrorCode::kTooLarge : ErrorCode::kTruncated;
  }
  if (read != in.size()) return ErrorCode::kCorrupt;
  return written;
}
#endif

#if PLED_WITH_ZSTD
[[nodiscard]] Result<std::size_t> unpack_zstd(void* context, std::span<const std::byte> in,
                                              std::span<std::byte> out) noexcept {
  const std::size_t written = ZSTD_decompressDCtx(static_cast<ZSTD_DCtx*>(context), out.data(),
                                                  out.size(), in.data(), in.size());
  if (ZSTD_isError(written) == 0) return written;
  switch (ZSTD_getErrorCode(written)) {
    case ZSTD_error_dstSize_tooSmall: return ErrorCode::kTooLarge;
    case ZSTD_error_srcSize_wrong: return ErrorCode::kTruncated;
    default: return ErrorCode::kCorrupt;
  }
}
#endif

}  // namespace

const char* Decompressor::missing_package(Compression compression) noexcept {
  switch (compression) {
    case Compression::kLz4: return "liblz4-dev";
    case Compression::kZstd: return "libzstd-dev";
    case Compression::kNone: break;
  }
  return "";
}

Result<Decompressor> Decompressor::create(Compression compression) noexcept {
  Decompressor made;
  made.compression_ = compression;
  if (compression == Compression::kNone) return made;
  void* context = nullptr;
#if PLED_WITH_LZ4
  if (compression == Compression::kLz4) {
    LZ4F_dctx* lz4 = nullptr;
    if (LZ4F_isError(LZ4F_createDecompressionContext(&lz4, LZ4F_VERSION)) != 0)
      return ErrorCode::kTooLarge;
    context = lz4;
    made.context_ = {context, {[](void* used) noexcept {
                       LZ4F_freeDecompressionContext(static_cast<LZ4F_dctx*>(used));
                     }}};
  }
#endif
#if PLED_WITH_ZSTD
  if (compression == Compression::kZstd) {
    context = ZSTD_createDCtx();
    if (context == nullptr) return ErrorCode::kTooLarge;
    made.context_ = {context,
                     {[](void* used) noexcept { ZSTD_freeDCtx(static_cast<ZSTD_DCtx*>(used)); }}};
  }
#endif
  if (context == nullptr) return ErrorCode::kUnsupported;
  return made;
}

Result<std::size_t> Decompressor::decompress(std::span<const std::byte> in,
                                             std::span<std::byte> out) noexcept {
#if PLED_WITH_LZ4
  if (compression_ == Compression::kLz4) return unpack_lz4(context_.get(), in, out);
#endif
#if PLED_WITH_ZSTD
  if (compression_ == Compression::kZstd) return unpack_zstd(context_.get(), in, out);
#endif
  if (in.size() > out.size()) return ErrorCode::kTooLarge;
  std::copy(in.begin(), in.end(), out.begin());
  return in.size();
}

}  // namespace pled::replay
