#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "drivers/replay/file.hpp"
#include "drivers/replay/recorded_source.hpp"
#include "pled_vins/core/limits.hpp"

namespace pled::replay {

/// The bytes of an event file in chunks of limits::kChunkBytes, as a device
/// would give them. Up to limits::kChunkSlots chunks may be held; a further
/// acquire() then says kTimeout. Memory: the slots, whatever the file's length.
class RawFileSource final : public RecordedEventSource {
 public:
  struct Options {
    std::int64_t skip_bytes = 0;     ///< header in front of the data
    bool ends_with_newline = false;  ///< text: supply the end of the last line if it has none
  };

  /// Allocates the slots. Errors: as File::open.
  [[nodiscard]] static Result<std::unique_ptr<RawFileSource>> open(const char* path,
                                                                   Options options);

  /// Goes back to the beginning. Errors: kIoFailure.
  Result<void> start() noexcept override;
  /// Errors: kEndOfStream, kTimeout (every slot is held), kIoFailure (final), detail = errno.
  Result<RawChunk> acquire(Duration timeout) noexcept override;
  void release() noexcept override;
  void stop() noexcept override { running_ = false; }

  [[nodiscard]] std::int64_t position() const noexcept override { return position_; }
  [[nodiscard]] std::int64_t size() const noexcept override {
    return file_.size() - options_.skip_bytes;
  }

 private:
  using Slot = std::array<std::byte, limits::kChunkBytes>;

  RawFileSource(File file, Options options);

  File file_;
  Options options_;
  std::unique_ptr<std::array<Slot, limits::kChunkSlots>> slots_;
  std::size_t first_held_ = 0;
  std::size_t held_ = 0;
  std::int64_t position_ = 0;
  bool running_ = false;
  bool finished_ = false;
  std::byte last_byte_{};
};

}  // namespace pled::replay
