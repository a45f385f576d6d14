#include "pled_vins/reliability/bin_clock.hpp"

#include <algorithm>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

constexpr std::int64_t kBins = limits::kTimeBins;
constexpr std::int64_t kJitterShare = 4;  // a frame is late by jitter up to 1/4 of a bin
/// Before the first frame bins run from so far back that no stamp lies before them; bin 0 begins at
/// time 0.
constexpr std::int64_t kBinsBeforeZero = std::int64_t{1} << 40;

/// a / b for b > 0, rounded towards the past.
constexpr std::int64_t floor_div(std::int64_t a, std::int64_t b) noexcept {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

}  // namespace

BinClock::BinClock(Duration width) noexcept : width_us_(width.us) {
  PLED_CHECK(width.us > 0);
  plans_[0] = {-kBinsBeforeZero * width_us_, -kBinsBeforeZero, width_us_, width_us_};
}

const BinClock::Plan& BinClock::plan(std::size_t age) const noexcept {
  return plans_[(newest_ + kPlans - age) % kPlans];
}

TimeBin BinClock::bin_in(const Plan& plan, std::int64_t t_us) noexcept {
  const std::int64_t since_us = t_us - plan.begin_us;
  const std::int64_t first_end_us = plan.begin_us + plan.first_length_us;
  if (since_us > 0 && t_us <= first_end_us) return {plan.first, {plan.begin_us}, {first_end_us}};
  // Bins own their end, not their begin: hence one microsecond less.
  if (since_us > 0) {
    const std::int64_t k = floor_div(t_us - first_end_us - 1, plan.length_us);
    const std::int64_t begin_us = first_end_us + k * plan.length_us;
    return {plan.first + 1 + k, {begin_us}, {begin_us + plan.length_us}};
  }
  const std::int64_t k = floor_div(since_us - 1, plan.length_us);
  const std::int64_t begin_us = plan.begin_us + k * plan.length_us;
  return {plan.first + k, {begin_us}, {begin_us + plan.length_us}};
}

TimeBin BinClock::bin_of(Timestamp t) const noexcept {
  std::size_t age = 0;
  while (age + 1 < num_plans_ && t.us <= plan(age).begin_us) ++age;
  TimeBin bin = bin_in(plan(age), t.us);
  // The plan ended where the next began, in the middle of a bin perhaps.
  if (age > 0) bin.end.us = std::min(bin.end.us, plan(age - 1).begin_us);
  return bin;
}

void BinClock::lay(std::int64_t begin_us, BinNumber first, std::int64_t min_first_us,
                   std::optional<std::int64_t> target_us) noexcept {
  Plan next{begin_us, first, std::max(width_us_, min_first_us), width_us_};
  const std::int64_t span_us = target_us.value_or(begin_us) - begin_us;
  if (span_us > min_first_us) {
    if (span_us >= kBins * width_us_) {
      next.first_length_us = span_us % width_us_;
    } else {
      const std::int64_t k = std::max<std::int64_t>(1, (span_us + width_us_ / 2) / width_us_);
      next.length_us = span_us / k;
      next.first_length_us = span_us - (k - 1) * next.length_us;
    }
    const std::int64_t missing_us = std::max<std::int64_t>(min_first_us, 1) - next.first_length_us;
    if (missing_us > 0)
      next.first_length_us += (missing_us + next.length_us - 1) / next.length_us * next.length_us;
  }
  // A plan that no instant has used is replaced.
  if (begin_us > plan(0).begin_us) {
    newest_ = (newest_ + 1) % kPlans;
    num_plans_ = std::min(num_plans_ + 1, kPlans);
  }
  plans_[newest_] = next;
}

bool BinClock::expect_frame(Timestamp t_frame, Timestamp t_binned) noexcept {
  if (!(t_frame > t_binned) || (t_frame_ && t_binned < *t_frame_)) return false;
  const Plan& now = plan(0);
  if (t_binned.us <= now.begin_us) {
    lay(now.begin_us, now.first, 0, t_frame.us);
    return true;
  }
  const TimeBin begun = bin_of(t_binned);
  if (begun.end == t_binned) {
    lay(begun.end.us, begun.number + 1, 0, t_frame.us);
  } else {
    lay(begun.begin.us, begun.number, (t_binned - begun.begin).us, t_frame.us);
  }
  return true;
}

BinNumber BinClock::on_frame(Timestamp t_frame) noexcept {
  const TimeBin bin = bin_of(t_frame);
  if (t_frame.us <= plan(0).begin_us || (t_frame_ && t_frame <= *t_frame_)) return bin.number;
  std::optional<std::int64_t> target_us;
  if (t_frame_) target_us = t_frame.us + (t_frame - *t_frame_).us;
  t_frame_ = t_frame;
  const std::int64_t open_us = (t_frame - bin.begin).us;
  if (t_frame < bin.end && open_us * kJitterShare <= plan(0).length_us) {
    lay(bin.begin.us, bin.number, open_us, target_us);
    return bin.number - 1;
  }
  lay(t_frame.us, bin.number + 1, 0, target_us);
  return bin.number;
}

}  // namespace pled
