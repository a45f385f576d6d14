#include "pled_vins/pipeline/event_feed.hpp"

#include <algorithm>

namespace pled {

void EventFeed::connect(EventSource& source, EventDecoder& decoder) noexcept {
  source_ = &source;
  decoder_ = &decoder;
  ended_ = false;
}

std::span<const Event> EventFeed::next(Timestamp until) noexcept {
  while (begin_ == end_) {
    if (ended_ || !refill()) return {};
  }
  const Event* first = batch_.data() + begin_;
  const Event* last = batch_.data() + end_;
  const Event* stop =
      std::partition_point(first, last, [until](const Event& e) { return e.t <= until; });
  begin_ += static_cast<std::size_t>(stop - first);
  return {first, stop};
}

bool EventFeed::refill() noexcept {
  begin_ = end_ = 0;
  if (!holds_chunk_) {
    const Result<RawChunk> chunk = source_->acquire(Duration::from_ms(0));
    if (!chunk.ok()) {
      const ErrorCode code = chunk.error().code;
      if (code == ErrorCode::kTimeout) return false;
      ended_ = true;
      decoder_->finish();
      if (code != ErrorCode::kEndOfStream) failure_ = chunk.error();
      return false;
    }
    if (chunk.value().after_gap) decoder_->resynchronise();
    chunk_ = chunk.value().bytes;
    holds_chunk_ = true;
  }
  const DecodeStep step = decoder_->decode(chunk_, batch_);
  chunk_ = chunk_.subspan(step.bytes_consumed);
  end_ = step.events;
  if (chunk_.empty()) {
    source_->release();
    holds_chunk_ = false;
  }
  return true;
}

}  // namespace pled
