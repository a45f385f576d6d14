#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/events/config.hpp"

namespace pled {

/// What one pixel remembers; all zero is a pixel that never fired. Stamps are the low 32 bits of
/// the time in microseconds; which of them are set, `state` says.
struct SurfacePixel {
  std::uint32_t last_us = 0;  ///< newest event of any polarity
  /// Bits 0, 1: polarity of the newest event, one bit each, none before the first. Bits 2, 3:
  /// filtered_us of that polarity is set. The rest: backlog of the rate meter, microseconds.
  std::uint32_t state = 0;
  std::array<std::uint32_t, 2> filtered_us{};  ///< newest accepted event, by polarity

  [[nodiscard]] bool fired(std::size_t polarity) const noexcept {
    return (state >> (2 + polarity) & 1U) != 0;
  }
};
static_assert(sizeof(SurfacePixel) == 16, "an event touches one cache line");

/// What became of one event.
enum class EventVerdict : std::uint8_t {
  kAccepted,   ///< on the filtered surface, and in the ring
  kRedundant,  ///< repeats its pixel's last event within kappa
  kHot,        ///< its pixel fires faster than any scene: ignored
  kDropped,    ///< outside the sensor, or its stamp goes back
};

/// An accepted event, packed.
struct RecentEvent {
  std::uint32_t t_us = 0;    ///< low 32 bits
  std::uint32_t packed = 0;  ///< x in bits 0 ... 15, y in bits 16 ... 30, polarity in bit 31

  [[nodiscard]] int x_px() const noexcept { return static_cast<int>(packed & 0xFFFF); }
  [[nodiscard]] int y_px() const noexcept { return static_cast<int>(packed >> 16 & 0x7FFF); }
  [[nodiscard]] std::size_t polarity() const noexcept { return packed >> 31; }
};
static_assert(sizeof(RecentEvent) == 8);

struct SurfaceCounts {
  std::uint64_t in = 0;
  std::uint64_t accepted = 0;
  std::uint64_t hot = 0;            ///< ignored: their pixels are hot
  std::uint64_t outside = 0;        ///< outside the sensor, dropped
  std::uint64_t strange_stamp = 0;  ///< below the newest, or kMaxJump_us above it: dropped
  std::uint64_t restarts = 0;       ///< kPatience strange stamps in a row: begun anew
};

/// The surface of active events: per pixel the newest event, and per polarity the newest that was
/// not redundant. An event is accepted when the one before it on its pixel had the other polarity
/// (of two with one stamp, the later in the stream is the newer), or is more than kappa older.
/// Stamps are 32 bits; a sweep that goes with the events' time forgets pixels without event for 18
/// minutes, before their stamps could wrap round and look new (72 minutes). How events are split
/// into packets makes no difference. No allocation, no thread.
class ActiveSurface {
 public:
  /// Largest step forward between events that is believed: 268 s.
  static constexpr std::int64_t kMaxJump_us = std::int64_t{1} << 28;
  /// Consecutive events with strange stamps after which they are right and the past is wrong.
  static constexpr std::uint64_t kPatience = 64;
  /// Largest sensor, pixels a side.
  static constexpr int kMaxSide_px = 16384;

  /// `pixels` holds width * height of them and outlives the object; it is cleared.
  ActiveSurface(const EventConfig& config, int width_px, int height_px,
                std::span<SurfacePixel> pixels) noexcept;

  /// Takes events in time order. Bad ones are counted and change nothing else.
  void insert(std::span<const Event> events) noexcept;
  /// The same; `verdicts` (at least as many) tells what became of each.
  void insert(std::span<const Event> events, std::span<EventVerdict> verdicts) noexcept;
  /// Forgets all events; counts stay.
  void clear() noexcept;

  [[nodiscard]] int width_px() const noexcept { return width_px_; }
  [[nodiscard]] int height_px() const noexcept { return height_px_; }
  /// Row-major.
  [[nodiscard]] std::span<const SurfacePixel> pixels() const noexcept { return pixels_; }
  [[nodiscard]] const SurfacePixel& at(int y_px, int x_px) const noexcept {
    return pixels_[static_cast<std::size_t>(y_px) * static_cast<std::size_t>(width_px_) +
                   static_cast<std::size_t>(x_px)];
  }
  /// Stamp of the newest event; nullopt before the first.
  [[nodiscard]] std::optional<Timestamp> newest() const noexcept;
  /// Stamp of the newest accepted event of a polarity; nullopt when none is remembered.
  [[nodiscard]] std::optional<Timestamp> filtered(int x_px, int y_px,
                                                  Polarity polarity) const noexcept;
  /// A 32-bit stamp of this surface in full.
  [[nodiscard]] Timestamp full_stamp(std::uint32_t t_us) const noexcept;

  /// Accepted events that are remembered, newest first.
  [[nodiscard]] std::size_t recent_size() const noexcept;
  [[nodiscard]] const RecentEvent& recent(std::size_t i) const noexcept {
    return ring_[(head_ - 1 - i) % limits::kEventRing];
  }

  [[nodiscard]] SurfaceCounts counts() const noexcept;

 private:
  static constexpr std::uint32_t kStale_us = 1U << 30;
  static constexpr int kSweepTickLog2_us = 20;
  static constexpr std::int64_t kSweepTicks = 512;  ///< in which every row has been swept

  template <bool kTell>
  void insert_all(std::span<const Event> events, EventVerdict* verdicts) noexcept;
  /// What a hot pixel's state becomes, given that with the event counted.
  [[nodiscard]] std::uint32_t hot_state(std::uint32_t state, std::uint32_t polarity) const noexcept;
  /// An event's stamp is below newest_us_ or not below horizon_us_: puts the clock right. False
  /// when the event is to be dropped.
  [[nodiscard]] bool admit(std::int64_t t_us, std::uint64_t number) noexcept;
  void sweep_until(std::int64_t t_us) noexcept;
  void sweep_row(int y, std::uint32_t now_us) noexcept;

  int width_px_;
  int height_px_;
  std::span<SurfacePixel> pixels_;
  std::uint32_t redundant_us_;
  std::uint32_t hot_period_us_;
  std::uint32_t hot_backlog_us_;

  bool has_clock_ = false;
  std::int64_t newest_us_ = std::numeric_limits<std::int64_t>::max();
  std::int64_t horizon_us_ = std::numeric_limits<std::int64_t>::min();  ///< next tick of the sweep
  int sweep_row_ = 0;
  std::uint64_t strange_run_ = 0;
  std::uint64_t last_strange_ = 0;  ///< number of the event

  std::array<RecentEvent, limits::kEventRing> ring_{};
  std::uint64_t head_ = 0;        ///< accepted events so far
  std::uint64_t ring_begin_ = 0;  ///< of those, forgotten by clear()
  SurfaceCounts counts_;
};

}  // namespace pled
