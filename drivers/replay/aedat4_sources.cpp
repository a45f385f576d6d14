#include "drivers/replay/aedat4_sources.hpp"

#include <algorithm>
#include <utility>

#include "pled_vins/core/check.hpp"
#include "pled_vins/core/limits.hpp"

namespace pled::replay {
namespace {

static_assert(limits::kChunkBytes % kAedat4EventBytes == 0);

/// The next packet of a stream, unpacked. Errors: Aedat4Reader's.
[[nodiscard]] Result<std::span<const std::byte>> next_of(Aedat4Reader& reader,
                                                         std::int32_t stream) noexcept {
  while (true) {
    const auto id = reader.next();
    if (!id.ok()) return id.error();
    if (id.value() == stream) return reader.payload();
  }
}

[[nodiscard]] bool is_final(ErrorCode code) noexcept {
  return code == ErrorCode::kEndOfStream || code == ErrorCode::kIoFailure;
}

void copy_as_grey(const Aedat4Frame& frame, std::span<std::uint8_t> out) noexcept {
  const auto* const in = reinterpret_cast<const std::uint8_t*>(frame.pixels.data());
  if (frame.format == Aedat4PixelFormat::kGrey) {
    std::copy(in, in + frame.pixels.size(), out.begin());
    return;
  }
  const std::size_t step = frame.format == Aedat4PixelFormat::kBgr ? 3 : 4;
  for (std::size_t i = 0; i < frame.pixels.size() / step; ++i) {
    const std::uint8_t* const bgr = in + i * step;
    out[i] = luma(bgr[2], bgr[1], bgr[0]);
  }
}

}  // namespace

Aedat4EventSource::Aedat4EventSource(Aedat4Reader reader, std::int32_t stream)
    : reader_(std::move(reader)), stream_(stream) {}

Result<void> Aedat4EventSource::start() noexcept {
  reader_.rewind();
  rest_ = {};
  held_ = 0;
  lost_ = 0;
  after_gap_ = false;
  running_ = true;
  return {};
}

Result<RawChunk> Aedat4EventSource::acquire(Duration /*timeout*/) noexcept {
  if (!running_) return ErrorCode::kEndOfStream;
  if (rest_.empty()) {
    if (held_ > 0) return ErrorCode::kTimeout;
    PLED_TRY(load());
  }
  const std::size_t bytes = std::min(rest_.size(), limits::kChunkBytes);
  const RawChunk chunk{rest_.first(bytes), Timestamp{}, std::exchange(after_gap_, false)};
  rest_ = rest_.subspan(bytes);
  ++held_;
  return chunk;
}

/// On to the next packet that holds events.
Result<void> Aedat4EventSource::load() noexcept {
  while (rest_.empty()) {
    const auto packet = next_of(reader_, stream_);
    if (!packet.ok() && is_final(packet.error().code)) return packet.error();
    const auto events = packet.ok() ? aedat4_events(packet.value()) : std::nullopt;
    if (events) {
      rest_ = *events;
    } else {
      ++lost_;
      after_gap_ = true;
    }
  }
  return {};
}

void Aedat4EventSource::release() noexcept {
  PLED_CHECK(held_ > 0);
  --held_;
}

Aedat4ImuSource::Aedat4ImuSource(Aedat4Reader reader, std::int32_t stream)
    : reader_(std::move(reader)), stream_(stream) {}

Result<ImuSample> Aedat4ImuSource::read(Duration /*timeout*/) noexcept {
  while (next_ == packet_.size()) PLED_TRY(load());
  if (const auto sample = packet_.sample(next_++)) return *sample;
  return bad("holds a sample without a stamp or finite numbers");
}

Result<void> Aedat4ImuSource::load() noexcept {
  packet_ = {};
  next_ = 0;
  const auto packet = next_of(reader_, stream_);
  if (!packet.ok() && is_final(packet.error().code)) return packet.error();
  if (!packet.ok()) return bad(nullptr);
  const auto samples = Aedat4ImuPacket::read(packet.value());
  if (!samples) return bad("holds no inertial samples");
  packet_ = *samples;
  return {};
}

Error Aedat4ImuSource::bad(const char* what) noexcept {
  ++malformed_;
  if (what != nullptr) reader_.blame(what);
  return {ErrorCode::kBadNumber, 0};
}

Aedat4FrameSource::Aedat4FrameSource(Aedat4Reader reader, std::int32_t stream,
                                     FrameSlots::Options options)
    : reader_(std::move(reader)), stream_(stream), slots_(options) {}

Result<FrameView> Aedat4FrameSource::acquire(Duration /*timeout*/) noexcept {
  if (slots_.full()) return ErrorCode::kTimeout;
  while (true) {
    const auto packet = next_of(reader_, stream_);
    if (!packet.ok() && is_final(packet.error().code)) return packet.error();
    if (!packet.ok()) return lost(nullptr);
    const auto frame = aedat4_frame(packet.value());
    if (!frame) return lost("holds no frame that can be read");
    const ImageSize size{frame->width_px, frame->height_px};
    if (!slots_.takes_stamp(frame->t_us)) {
      reader_.blame("holds a frame whose stamp is not later than that of the one before");
      continue;
    }
    if (!slots_.takes_size(size)) {
      reader_.blame("holds a frame of another size than the others");
      return Error{ErrorCode::kCorrupt, 0};
    }
    copy_as_grey(*frame, slots_.next_slot());
    return slots_.push(frame->t_us, size);
  }
}

Error Aedat4FrameSource::lost(const char* what) noexcept {
  slots_.count_unreadable();
  if (what != nullptr) reader_.blame(what);
  return {ErrorCode::kCorrupt, 0};
}

std::string_view Aedat4FrameSource::last_message() const noexcept { return reader_.last_message(); }

}  // namespace pled::replay
