#include "drivers/decode/event_clock.hpp"

#include <limits>

namespace pled {
namespace {

/// Stamps have any value, so no difference is taken.
bool is_far_below(std::int64_t t_us, std::int64_t from_us) noexcept {
  return from_us >= std::numeric_limits<std::int64_t>::min() + EventClock::kFar_us &&
         t_us < from_us - EventClock::kFar_us;
}

}  // namespace

Event EventClock::held(Event event, DecoderFaults& faults) noexcept {
  if (has_time_ && event.t.us < last_us_) {
    if (!was_set_back(event.t.us)) {
      ++faults.time_backwards;
      event.t.us = last_us_;
      return event;
    }
    ++faults.gaps;
  }
  has_time_ = true;
  last_us_ = event.t.us;
  run_ = 0;
  return event;
}

bool EventClock::was_set_back(std::int64_t t_us) noexcept {
  const bool far = is_far_below(t_us, last_us_);
  const bool follows = run_ > 0 && t_us >= back_us_ && !is_far_below(back_us_, t_us);
  run_ = !far ? 0 : follows ? run_ + 1 : 1;
  back_us_ = t_us;
  return run_ >= kPatience;
}

}  // namespace pled
