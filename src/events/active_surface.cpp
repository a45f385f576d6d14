#include "pled_vins/events/active_surface.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

// Instants beyond this are no instants: sums with them could overflow.
constexpr std::int64_t kMaxInstant_us = std::int64_t{1} << 62;

// Bits of SurfacePixel::state.
constexpr std::uint32_t kLastOff = 1;
constexpr std::uint32_t kLastBoth = 3;
constexpr std::uint32_t kFilteredOff = 4;
constexpr std::uint32_t kFlags = 15;
constexpr int kBacklogShift = 4;

/// What an event of a polarity sets: (kLastOff | kFilteredOff) << polarity.
std::uint32_t fired(std::uint32_t polarity) noexcept {
  return (kLastOff | kFilteredOff) + (kLastOff | kFilteredOff) * polarity;
}

std::uint32_t low32(std::int64_t t_us) noexcept { return static_cast<std::uint32_t>(t_us); }

/// The rate meter, after an event: a tank that each event fills by one period and time drains. The
/// flags below it stay as they are.
std::uint32_t metered(std::uint32_t state, std::uint32_t age_us, std::uint32_t period) noexcept {
  const std::uint64_t drain = std::uint64_t{age_us} << kBacklogShift;
  std::uint64_t drained = 0;
  if (__builtin_sub_overflow(std::uint64_t{state}, drain, &drained)) drained = state & kFlags;
  return static_cast<std::uint32_t>(drained) + period;
}

/// RecentEvent::packed: x and y lie side by side in an event.
std::uint32_t packed(const Event& e, std::uint32_t polarity) noexcept {
  static_assert(offsetof(Event, y_px) == offsetof(Event, x_px) + 2);
  static_assert(std::endian::native == std::endian::little);
  std::uint32_t xy = 0;
  std::memcpy(&xy, reinterpret_cast<const char*>(&e) + offsetof(Event, x_px), sizeof(xy));
  return xy | polarity << 31;
}

}  // namespace

ActiveSurface::ActiveSurface(const EventConfig& config, int width_px, int height_px,
                             std::span<SurfacePixel> pixels) noexcept
    : width_px_(width_px),
      height_px_(height_px),
      redundant_us_(static_cast<std::uint32_t>(std::lround(1e3 * config.redundant_ms))),
      hot_period_us_(static_cast<std::uint32_t>(std::lround(1e6 / config.hot_rate_hz))),
      hot_backlog_us_(hot_period_us_ * static_cast<std::uint32_t>(config.hot_burst)) {
  PLED_CHECK(check(config).key == nullptr);
  PLED_CHECK(width_px >= 1 && width_px <= kMaxSide_px);
  PLED_CHECK(height_px >= 1 && height_px <= kMaxSide_px);
  const std::size_t size = static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  PLED_CHECK(pixels.size() >= size);
  pixels_ = pixels.first(size);
  clear();
}

void ActiveSurface::clear() noexcept {
  std::fill(pixels_.begin(), pixels_.end(), SurfacePixel{});
  has_clock_ = false;
  newest_us_ = std::numeric_limits<std::int64_t>::max();  // every stamp asks admit() first
  horizon_us_ = std::numeric_limits<std::int64_t>::min();
  sweep_row_ = 0;
  ring_begin_ = head_;
}

void ActiveSurface::insert(std::span<const Event> events) noexcept {
  insert_all<false>(events, nullptr);
}

void ActiveSurface::insert(std::span<const Event> events,
                           std::span<EventVerdict> verdicts) noexcept {
  PLED_CHECK(verdicts.size() >= events.size());
  insert_all<true>(events, verdicts.data());
}

template <bool kTell>
void ActiveSurface::insert_all(std::span<const Event> events, EventVerdict* verdicts) noexcept {
  // Copies, which no store to a pixel can change.
  SurfacePixel* const pixels = pixels_.data();
  const auto width = static_cast<std::uint32_t>(width_px_);
  const auto height = static_cast<std::uint32_t>(height_px_);
  const std::uint32_t redundant_us = redundant_us_;
  const std::uint32_t period = hot_period_us_ << kBacklogShift;
  const std::uint32_t hot = hot_backlog_us_ << kBacklogShift | kFlags;
  std::uint64_t head = head_;
  const auto tell = [&](EventVerdict verdict) {
    if constexpr (kTell) *verdicts++ = verdict;
  };
  for (const Event& e : events) {
    const std::int64_t t_us = e.t.us;
    const std::uint32_t x = e.x_px;
    const std::uint32_t y = e.y_px;
    if (x >= width || y >= height) [[unlikely]] {
      ++counts_.outside;
      tell(EventVerdict::kDropped);
      continue;
    }
    if (t_us < newest_us_ || t_us >= horizon_us_) [[unlikely]] {
      head_ = head;
      if (!admit(t_us, counts_.in + static_cast<std::uint64_t>(&e - events.data()))) {
        tell(EventVerdict::kDropped);
        continue;
      }
    }
    newest_us_ = t_us;
    const std::uint32_t t = low32(t_us);
    const auto p = static_cast<std::uint32_t>(e.polarity);
    SurfacePixel& pixel = pixels[y * width + x];
    std::uint32_t state = pixel.state;
    const std::uint32_t age = t - pixel.last_us;
    pixel.last_us = t;

    const std::uint32_t accepted = static_cast<std::uint32_t>((state >> p & 1U) == 0) |
                                   static_cast<std::uint32_t>(age > redundant_us);
    state = metered(state, age, period);
    if (state > hot) [[unlikely]] {
      pixel.state = hot_state(state, p);
      ++counts_.hot;
      tell(EventVerdict::kHot);
      continue;
    }
    pixel.state = (state & ~kLastBoth) | fired(p);
    // Half of the events are redundant, without a pattern: a branch would be mispredicted.
    std::uint32_t& filtered = pixel.filtered_us[p];
    const std::uint32_t before = filtered;
    filtered = __builtin_expect_with_probability(accepted != 0, 1, 0.5) ? t : before;
    // Written in any case, but part of the ring only when accepted.
    ring_[head % limits::kEventRing] = {t, packed(e, p)};
    head += accepted;
    tell(accepted != 0 ? EventVerdict::kAccepted : EventVerdict::kRedundant);
  }
  head_ = head;
  counts_.in += events.size();
}

std::uint32_t ActiveSurface::hot_state(std::uint32_t state, std::uint32_t polarity) const noexcept {
  // Twice the limit at most, so that a pixel must rest before it is heard again.
  const std::uint32_t backlog_us = std::min(state >> kBacklogShift, 2 * hot_backlog_us_);
  return backlog_us << kBacklogShift | (state & kFlags & ~kLastBoth) | kLastOff << polarity;
}

bool ActiveSurface::admit(std::int64_t t_us, std::uint64_t number) noexcept {
  const bool plausible = t_us > -kMaxInstant_us && t_us < kMaxInstant_us;
  if (has_clock_ && plausible && t_us >= newest_us_ && t_us - newest_us_ <= kMaxJump_us) {
    sweep_until(t_us);
    return true;
  }
  if (has_clock_ || !plausible) {
    strange_run_ = number == last_strange_ + 1 ? strange_run_ + 1 : 1;
    last_strange_ = number;
    ++counts_.strange_stamp;
    if (!plausible || strange_run_ < kPatience) return false;
    --counts_.strange_stamp;  // this one is taken
    ++counts_.restarts;
    clear();
  }
  has_clock_ = true;
  strange_run_ = 0;
  newest_us_ = t_us;
  horizon_us_ = ((t_us >> kSweepTickLog2_us) + 1) << kSweepTickLog2_us;
  return true;
}

void ActiveSurface::sweep_until(std::int64_t t_us) noexcept {
  const std::int64_t ticks = ((t_us - horizon_us_) >> kSweepTickLog2_us) + 1;
  const std::int64_t rows_per_tick = (height_px_ + kSweepTicks - 1) / kSweepTicks;
  const std::int64_t rows = std::min<std::int64_t>(ticks * rows_per_tick, height_px_);
  for (std::int64_t i = 0; i < rows; ++i) {
    sweep_row(sweep_row_, low32(t_us));
    sweep_row_ = sweep_row_ + 1 == height_px_ ? 0 : sweep_row_ + 1;
  }
  horizon_us_ += ticks << kSweepTickLog2_us;
}

void ActiveSurface::sweep_row(int y, std::uint32_t now_us) noexcept {
  const std::size_t width = static_cast<std::size_t>(width_px_);
  for (SurfacePixel& pixel : pixels_.subspan(static_cast<std::size_t>(y) * width, width)) {
    if (now_us - pixel.last_us > kStale_us) {
      pixel = SurfacePixel{};
      continue;
    }
    // A pixel that fires on, with one polarity and nothing but redundant events: its stamp stays
    // old instead of wrapping round.
    for (std::uint32_t& stamp : pixel.filtered_us) {
      if (now_us - stamp > kStale_us) stamp = now_us - kStale_us;
    }
  }
}

std::optional<Timestamp> ActiveSurface::newest() const noexcept {
  if (!has_clock_) return std::nullopt;
  return Timestamp{newest_us_};
}

Timestamp ActiveSurface::full_stamp(std::uint32_t t_us) const noexcept {
  return {newest_us_ - static_cast<std::int64_t>(low32(newest_us_) - t_us)};
}

std::optional<Timestamp> ActiveSurface::filtered(int x_px, int y_px,
                                                 Polarity polarity) const noexcept {
  const auto p = static_cast<std::size_t>(polarity);
  const SurfacePixel& pixel = at(y_px, x_px);
  if (!pixel.fired(p)) return std::nullopt;
  return full_stamp(pixel.filtered_us[p]);
}

std::size_t ActiveSurface::recent_size() const noexcept {
  // The slot after the newest belongs to the event that comes next.
  return static_cast<std::size_t>(
      std::min<std::uint64_t>(head_ - ring_begin_, limits::kEventRing - 1));
}

SurfaceCounts ActiveSurface::counts() const noexcept {
  SurfaceCounts counts = counts_;
  counts.accepted = head_;
  return counts;
}

}  // namespace pled
