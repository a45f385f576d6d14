#include "pled_vins/pipeline/inline_runner.hpp"

#include <algorithm>

namespace pled {
namespace {

// Inertial samples this long before the first frame are kept, so that the first
// interval is covered to its start.
constexpr Duration kImuLead = Duration::from_ms(50);
// An event stream that ends no longer than this before a frame has ended with it.
constexpr Duration kEventPause = Duration::from_ms(100);

}  // namespace

RunEnd InlineRunner::run(const RunSources& sources, const RunSpan& span,
                         ResultSink& sink) noexcept {
  sources_ = sources;
  end_ = {};
  if (sources.events != nullptr && sources.event_decoder != nullptr)
    event_feed_.connect(*sources.events, *sources.event_decoder);
  FrameView frame;
  for (Next next = next_frame(span, frame); next != Next::kEnd; next = next_frame(span, frame)) {
    if (next == Next::kSkip) continue;
    const bool go_on = play(frame, sink);
    sources_.frames->release();
    if (!go_on) {
      end_.stopped_by_sink = true;
      break;
    }
  }
  collect_event_faults();
  health_.count(Fault::kImuBackwards, imu_leaps_);
  return end_;
}

InlineRunner::Next InlineRunner::next_frame(const RunSpan& span, FrameView& frame) noexcept {
  const Result<FrameView> read = [this] {
    const StageTimer timer(health_, Stage::kRead);
    return sources_.frames->acquire(Duration::from_ms(0));
  }();
  if (!read.ok()) return after_failed_read(read.error());
  frame = read.value();
  if (!stamp_holds(frame)) {
    sources_.frames->release();
    return Next::kSkip;
  }
  if (!origin_) origin_ = frame.t;
  if (span.length && frame.t > *origin_ + span.start + *span.length) {
    sources_.frames->release();
    return Next::kEnd;
  }
  if (frame.t < *origin_ + span.start) {
    sources_.frames->release();
    return Next::kSkip;
  }
  return Next::kFrame;
}

/// False for a wild stamp, which is counted. A clock that jumped is followed.
bool InlineRunner::stamp_holds(const FrameView& frame) noexcept {
  const std::optional<Timestamp> last = frame_guard_.last();
  const StampGuard::Verdict verdict = frame_guard_.judge(frame.t);
  if (verdict == StampGuard::Verdict::kWild) {
    ++health_.frames.in;
    ++health_.frames.dropped;
    health_.count(Fault::kFrameStampWild);
    return false;
  }
  if (verdict == StampGuard::Verdict::kJumped) {
    *origin_ = *origin_ + (frame.t - *last);  // the span goes on by the new clock
    from_ = imu_from_ = Timestamp{INT64_MIN};
    newest_imu_ = Timestamp{INT64_MIN};
    imu_guard_.restart(std::nullopt);
    pipeline_.on_clock_jump();
  }
  return true;
}

bool InlineRunner::stamp_holds(const ImuSample& sample, Timestamp until) noexcept {
  // Nothing to go on from: it must belong to the frame.
  if (!imu_guard_.last() && sample.t > until) imu_guard_.restart(until);
  const StampGuard::Verdict verdict = imu_guard_.judge(sample.t);
  if (verdict == StampGuard::Verdict::kWild) {
    ++health_.imu.in;
    ++health_.imu.dropped;
    health_.count(Fault::kImuStampWild);
    return false;
  }
  if (verdict == StampGuard::Verdict::kJumped) {
    newest_imu_ = imu_from_ = Timestamp{INT64_MIN};
    pipeline_.on_clock_jump();
  }
  return true;
}

InlineRunner::Next InlineRunner::after_failed_read(Error error) noexcept {
  switch (error.code) {
    case ErrorCode::kEndOfStream: return Next::kEnd;
    case ErrorCode::kCorrupt:
    case ErrorCode::kTruncated:
    case ErrorCode::kNotFound:
    case ErrorCode::kBadNumber:
    case ErrorCode::kUnsupported:
    case ErrorCode::kTooLarge:
      ++health_.frames.in;
      ++health_.frames.dropped;
      health_.count(Fault::kFrameUnreadable);
      return Next::kSkip;
    default: end_.frame_failure = error; return Next::kEnd;
  }
}

bool InlineRunner::play(const FrameView& frame, ResultSink& sink) noexcept {
  if (!end_.first_stamp_ns) {
    sink.on_start();
    end_.first_stamp_ns = frame.stamp_ns;
    from_ = frame.t;
    imu_from_ = pipeline_.frame_time(frame) - kImuLead;
  }
  end_.last_stamp_ns = std::max(end_.last_stamp_ns.value_or(frame.stamp_ns), frame.stamp_ns);
  feed_imu(pipeline_.frame_time(frame));
  pipeline_.expect(frame);
  feed_events(pipeline_.last_event_time(frame));
  FrameResult result;
  {
    const StageTimer timer(health_, Stage::kFrame);
    if (!pipeline_.on_frame(frame, result)) return true;
  }
  return sink.on_frame(result);
}

std::optional<ImuSample> InlineRunner::next_readable_imu() noexcept {
  while (!imu_ended_) {
    const Result<ImuSample> read = sources_.imu->read(Duration::from_ms(0));
    if (read.ok()) return read.value();
    if (read.error().code == ErrorCode::kBadNumber) {
      ++health_.imu.in;
      ++health_.imu.dropped;
      health_.count(Fault::kImuUnreadable);
      continue;
    }
    imu_ended_ = true;
    if (read.error().code != ErrorCode::kEndOfStream) end_.imu_failure = read.error();
  }
  return std::nullopt;
}

bool InlineRunner::read_imu(ImuSample& sample) noexcept {
  if (!imu_ahead_) imu_ahead_ = next_readable_imu();
  while (imu_ahead_) {
    sample = *imu_ahead_;
    imu_ahead_ = next_readable_imu();
    // A stamp later than that of the next sample, which itself goes on from the ones before, is
    // wrong: believed, it would make every sample after it one that goes back.
    // Of leaps so long that a clock may have jumped, stamp_holds() decides.
    const bool leaps = imu_ahead_ && imu_ahead_->t < sample.t && imu_ahead_->t > newest_imu_ &&
                       sample.t - imu_ahead_->t <= StampGuard::kLongest;
    if (!leaps) return true;
    ++health_.imu.in;
    ++health_.imu.dropped;
    ++imu_leaps_;
  }
  return false;
}

void InlineRunner::feed_imu(Timestamp until) noexcept {
  ImuSample sample;
  while (newest_imu_ < until && read_imu(sample)) {
    const Timestamp before = newest_imu_;
    if (!stamp_holds(sample, until) || sample.t < imu_from_) continue;
    newest_imu_ = std::max(newest_imu_, sample.t);
    pipeline_.on_imu(sample);
    // Set back: no later sample reaches this frame. The next may be on the new clock as well.
    if (newest_imu_ < before) return;
  }
}

void InlineRunner::feed_events(Timestamp until) noexcept {
  const StageTimer timer(health_, Stage::kEvents);
  for (;;) {
    std::span<const Event> events = event_feed_.next(until);
    if (events.empty()) break;
    newest_event_ = events.back().t;
    const Event* first = std::partition_point(events.data(), events.data() + events.size(),
                                              [this](const Event& e) { return e.t < from_; });
    pipeline_.on_events({first, events.data() + events.size()});
  }
  end_.event_failure = event_feed_.failure();
  const bool has_events = event_feed_.decoder() != nullptr;
  // Written so that the least stamp, of a stream without one event, does not overflow.
  if (has_events && event_feed_.ended() && newest_event_ < until - kEventPause)
    health_.count(Fault::kFrameWithoutEvents);
}

void InlineRunner::collect_event_faults() noexcept {
  const EventDecoder* decoder = event_feed_.decoder();
  if (decoder == nullptr) return;
  const DecoderFaults& faults = decoder->faults();
  health_.set(Fault::kEventOutsideSensor, faults.outside_sensor);
  health_.set(Fault::kEventTimeBackwards, faults.time_backwards);
  health_.set(Fault::kEventMalformed, faults.malformed);
  health_.set(Fault::kEventGap, faults.gaps);
  health_.events.in += faults.outside_sensor;
  health_.events.dropped += faults.outside_sensor;
}

}  // namespace pled
