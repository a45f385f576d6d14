#include "drivers/replay/raw_file_source.hpp"

#include <utility>

#include "pled_vins/core/check.hpp"

namespace pled::replay {

RawFileSource::RawFileSource(File file, Options options)
    : file_(std::move(file)),
      options_(options),
      slots_(std::make_unique<std::array<Slot, limits::kChunkSlots>>()) {}

Result<std::unique_ptr<RawFileSource>> RawFileSource::open(const char* path, Options options) {
  auto file = File::open(path);
  if (!file.ok()) return file.error();
  return std::unique_ptr<RawFileSource>(
      new RawFileSource(std::move(file).value(), options));  // private constructor
}

Result<void> RawFileSource::start() noexcept {
  PLED_TRY(file_.seek(options_.skip_bytes));
  position_ = 0;
  first_held_ = 0;
  held_ = 0;
  finished_ = false;
  last_byte_ = std::byte{'\n'};
  running_ = true;
  return {};
}

Result<RawChunk> RawFileSource::acquire(Duration /*timeout*/) noexcept {
  if (!running_ || finished_) return ErrorCode::kEndOfStream;
  if (held_ == limits::kChunkSlots) return ErrorCode::kTimeout;
  Slot& slot = (*slots_)[(first_held_ + held_) % limits::kChunkSlots];
  const auto got = file_.read(slot);
  if (!got.ok()) {
    finished_ = true;
    return got.error();
  }
  std::size_t bytes = got.value();
  position_ += static_cast<std::int64_t>(bytes);
  if (bytes != 0) last_byte_ = slot[bytes - 1];
  if (bytes < slot.size()) {
    finished_ = true;
    if (options_.ends_with_newline && last_byte_ != std::byte{'\n'})
      slot[bytes++] = std::byte{'\n'};
  }
  if (bytes == 0) return ErrorCode::kEndOfStream;
  ++held_;
  return RawChunk{std::span{slot}.first(bytes), Timestamp{}, false};
}

void RawFileSource::release() noexcept {
  PLED_CHECK(held_ > 0);
  first_held_ = (first_held_ + 1) % limits::kChunkSlots;
  --held_;
}

}  // namespace pled::replay
