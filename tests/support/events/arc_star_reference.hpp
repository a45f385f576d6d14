#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "pled_vins/events/active_surface.hpp"

namespace pled::support {

/// The pixels of a circle in the order of the paper's figure, from straight below.
[[nodiscard]] inline std::vector<std::pair<int, int>> circle_pixels(int radius) {
  // One octave's worth of steps, mirrored: a Bresenham circle of radius 3 or 4.
  const std::vector<std::pair<int, int>> quarter =
      radius == 3 ? std::vector<std::pair<int, int>>{{0, 3}, {1, 3}, {2, 2}, {3, 1}}
                  : std::vector<std::pair<int, int>>{{0, 4}, {1, 4}, {2, 3}, {3, 2}, {4, 1}};
  std::vector<std::pair<int, int>> circle;
  std::pair<int, int> turned(1, 0);  // multiplies by i^-k
  for (int k = 0; k < 4; ++k) {
    for (const auto& [x, y] : quarter)
      circle.emplace_back(x * turned.first + y * turned.second,
                          -x * turned.second + y * turned.first);
    turned = {turned.second, -turned.first};
    turned = {-turned.first, -turned.second};
  }
  return circle;
}

/// Size of the newest arc, with sets instead of running minima: all pixels visited are kept, and
/// the oldest is found by sorting each time.
[[nodiscard]] inline int newest_arc_by_sets(
    const std::vector<std::optional<std::int64_t>>& stamps_us, int shortest) {
  const int n = static_cast<int>(stamps_us.size());
  const auto at = [&](int i) { return stamps_us[static_cast<std::size_t>((i % n + n) % n)]; };
  // An empty optional is less than any stamp: never fired is older than all.
  int start = 0;
  for (int i = 1; i < n; ++i)
    if (at(i) > at(start)) start = i;
  int first = start;  // the arc visited so far is first ... last
  int last = start;
  int segment_first = start;  // the newest segment is a part of it, from one end to the other
  int segment_last = start;
  const auto oldest_of = [&](int from, int to) {
    std::vector<std::optional<std::int64_t>> stamps;
    for (int i = from; i <= to; ++i) stamps.push_back(at(i));
    std::sort(stamps.begin(), stamps.end());
    return stamps.front();
  };
  for (int visited = 2; visited <= n; ++visited) {
    const bool up = at(last + 1) > at(first - 1);
    const std::optional<std::int64_t> next = up ? at(last + 1) : at(first - 1);
    const std::optional<std::int64_t> oldest = oldest_of(segment_first, segment_last);
    if (up)
      ++last;
    else
      --first;
    if (visited <= shortest || next >= oldest) {
      segment_first = first;
      segment_last = last;
    }
  }
  return segment_last - segment_first + 1;
}

/// Arc* as defined, read through the surface's public stamps.
[[nodiscard]] inline bool arc_star_by_sets(const ActiveSurface& surface, int x, int y,
                                           Polarity polarity) {
  struct Rule {
    int radius, pixels, shortest, longest;
  };
  for (const Rule& rule : {Rule{3, 16, 3, 6}, Rule{4, 20, 4, 8}}) {
    std::vector<std::optional<std::int64_t>> stamps_us;
    for (const auto& [dx, dy] : circle_pixels(rule.radius)) {
      const std::optional<Timestamp> t = surface.filtered(x + dx, y + dy, polarity);
      stamps_us.push_back(t ? std::optional(t->us) : std::nullopt);
    }
    const int arc = newest_arc_by_sets(stamps_us, rule.shortest);
    const bool is_short = arc >= rule.shortest && arc <= rule.longest;
    const bool is_complement =
        arc >= rule.pixels - rule.longest && arc <= rule.pixels - rule.shortest;
    if (!is_short && !is_complement) return false;
  }
  return true;
}

}  // namespace pled::support
