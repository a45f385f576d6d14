#include "pled_vins/pipeline/event_feed.hpp"

#include <algorithm>
#include <limits>

#include "pled_vins/pipeline/stamp_guard.hpp"

namespace pled {
namespace {

/// Whether a stamp lies further ahead of another than stamps of one clock do; they have any value,
/// so no difference is taken.
bool is_far(Timestamp ahead, Timestamp t) noexcept {
  constexpr Duration kFar = StampGuard::kLongest;
  return t.us < std::numeric_limits<std::int64_t>::max() - kFar.us && ahead > t + kFar;
}

}  // namespace

void EventFeed::connect(EventSource& source, EventDecoder& decoder) noexcept {
  source_ = &source;
  decoder_ = &decoder;
  ended_ = false;
}

std::span<const Event> EventFeed::next(Timestamp until) noexcept {
  if (is_far(until_, until)) left_ = until_;
  until_ = until;
  for (;;) {
    if (begin_ == end_) {
      if (ended_ || !refill()) return {};
      continue;
    }
    if (begin_ == run_end_) find_run_end();
    const Timestamp t = batch_[begin_].t;
    if (t > until) {
      if (!is_left_behind(t, until)) return {};
      begin_ = run_end_;
      continue;
    }
    if (must_wait(t, until)) return {};
    break;
  }
  const Event* first = batch_.data() + begin_;
  const Event* last = batch_.data() + run_end_;
  const Event* stop =
      std::partition_point(first, last, [until](const Event& e) { return e.t <= until; });
  begin_ += static_cast<std::size_t>(stop - first);
  given_ = (stop - 1)->t;
  waited_.reset();
  left_.reset();
  return {first, stop};
}

/// Whether an event ahead of `until` will never be asked for: it is what is left of a clock that
/// was set back, or one of a few wild stamps behind which time goes on.
bool EventFeed::is_left_behind(Timestamp t, Timestamp until) noexcept {
  if (!is_far(t, until)) return false;
  return (left_ && t > *left_ && !is_far(t, *left_)) || another_run_follows();
}

/// Whether the event lies behind a step back that who asks may be about to make as well.
bool EventFeed::must_wait(Timestamp t, Timestamp until) noexcept {
  if (!given_ || !is_far(*given_, t) || is_far(*given_, until)) return false;
  if (!waited_) waited_ = until;
  return *waited_ == until;
}

/// Reads on, as far as there is room.
bool EventFeed::another_run_follows() noexcept {
  while (run_end_ == end_ && batch_.size() - (end_ - begin_) >= EventDecoder::kMinOutput &&
         !ended_ && refill()) {
  }
  return run_end_ != end_;
}

void EventFeed::find_run_end() noexcept {
  const Event* const stop =
      std::is_sorted_until(batch_.data() + begin_, batch_.data() + end_,
                           [](const Event& a, const Event& b) { return a.t < b.t; });
  run_end_ = static_cast<std::size_t>(stop - batch_.data());
}

/// Decodes behind the events that are left.
bool EventFeed::refill() noexcept {
  std::copy(batch_.data() + begin_, batch_.data() + end_, batch_.data());
  end_ -= begin_;
  begin_ = 0;
  run_end_ = end_;
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
  const DecodeStep step = decoder_->decode(chunk_, std::span(batch_).subspan(end_));
  chunk_ = chunk_.subspan(step.bytes_consumed);
  end_ += step.events;
  find_run_end();
  if (chunk_.empty()) {
    source_->release();
    holds_chunk_ = false;
  }
  return true;
}

}  // namespace pled
