#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "pled_vins/events/active_surface.hpp"

namespace pled::support {

/// A surface with memory of its own.
struct OwnedSurface {
  OwnedSurface(int width_px, int height_px, const EventConfig& config = {})
      : memory(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px),
               SurfacePixel{0xDEADBEEF, 0xDEADBEEF, {0xDEADBEEF, 0xDEADBEEF}}),
        surface(config, width_px, height_px, memory) {}

  std::vector<SurfacePixel> memory;
  ActiveSurface surface;
};

[[nodiscard]] inline Event event_at(std::int64_t t_us, int x_px, int y_px,
                                    Polarity polarity = Polarity::kOn) {
  return {{t_us}, static_cast<std::uint16_t>(x_px), static_cast<std::uint16_t>(y_px), polarity};
}

/// Events anywhere on a small sensor, so that pixels are hit again: steps of 0, a few, and
/// sometimes many microseconds, and runs on one pixel.
[[nodiscard]] inline std::vector<Event> busy_stream(std::uint64_t seed, std::size_t count,
                                                    int width_px, int height_px,
                                                    std::int64_t begin_us) {
  std::mt19937_64 random(seed);
  const auto below = [&](std::uint64_t n) { return static_cast<std::int64_t>(random() % n); };
  std::vector<Event> events;
  std::int64_t t_us = begin_us;
  while (events.size() < count) {
    const auto x = static_cast<int>(below(static_cast<std::uint64_t>(width_px)));
    const auto y = static_cast<int>(below(static_cast<std::uint64_t>(height_px)));
    const std::int64_t run = below(8) == 0 ? 1 + below(40) : 1;
    for (std::int64_t k = 0; k < run && events.size() < count; ++k) {
      t_us += below(4) == 0 ? 0 : below(3) == 0 ? below(2000) : below(100);
      events.push_back(event_at(t_us, x, y, below(3) == 0 ? Polarity::kOff : Polarity::kOn));
    }
  }
  return events;
}

/// Calls `insert` with the whole of `events` in packets of random sizes, empty ones too.
template <typename Insert>
void in_packets(std::uint64_t seed, std::span<const Event> events, const Insert& insert) {
  std::mt19937_64 random(seed);
  while (!events.empty()) {
    const std::size_t n = std::min<std::size_t>(events.size(), random() % 50);
    insert(events.first(n));
    events = events.subspan(n);
  }
}

}  // namespace pled::support
