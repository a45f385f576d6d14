#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>

#include "pled_vins/core/timestamp.hpp"
#include "pled_vins/reliability/bin_counters.hpp"
#include "pled_vins/reliability/entropy_recency.hpp"

/// The entropy-recency map as the paper writes it down, slowly and from scratch.
namespace pled::support {

inline constexpr std::size_t kB = limits::kTimeBins;
using SlowCounts = std::array<int, kB>;

/// Eqs. (2) to (5), sums and logarithms as printed.
inline PixelScore score_by_definition(const SlowCounts& c, double alpha, double epsilon) {
  const double B = static_cast<double>(kB);
  int n = 0;
  for (const int count : c) n += count;
  double h = 0.0;
  double q = -std::exp(-alpha);
  for (std::size_t k = 0; k < kB; ++k) {
    const double p = c[k] / (n + epsilon);
    if (p + epsilon > 0.0) h -= p * std::log(p + epsilon) / std::log(B);
    q += p * std::exp(-alpha * (1.0 - (static_cast<double>(k) + 0.5) / B));
  }
  q /= 1.0 - std::exp(-alpha) + epsilon;
  const double s = h * q / (h * q + (1.0 - h) * (1.0 - q));
  return {h, q, s, static_cast<std::uint32_t>(n)};
}

inline SlowCounts slow(const BinCounts& counts) {
  SlowCounts out{};
  for (std::size_t k = 0; k < kB; ++k) out[k] = counts[k];
  return out;
}

inline BinCounts narrow(const SlowCounts& counts) {
  BinCounts out{};
  for (std::size_t k = 0; k < kB; ++k) out[k] = static_cast<std::uint8_t>(counts[k]);
  return out;
}

/// An event after its warp.
struct TimedPixel {
  Timestamp t;
  WarpedPixel at;
};

/// c_k of every pixel that has events in (t_end - B width, t_end], the bins being of that width and
/// the last one ending at t_end.
using BatchCounts = std::map<std::pair<int, int>, SlowCounts>;
inline BatchCounts batch_counts(std::span<const TimedPixel> events, Timestamp t_end,
                                Duration width) {
  BatchCounts out;
  for (const TimedPixel& event : events) {
    const std::int64_t age_us = (t_end - event.t).us;
    if (age_us < 0 || age_us >= static_cast<std::int64_t>(kB) * width.us) continue;
    const std::size_t k = kB - 1 - static_cast<std::size_t>(age_us / width.us);
    ++out[{event.at.x_px, event.at.y_px}][k];
  }
  return out;
}

}  // namespace pled::support
