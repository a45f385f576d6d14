#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace pled::sim {

/// Mixes 64 bits (the finaliser of SplitMix64, Steele et al. 2014).
[[nodiscard]] constexpr std::uint64_t mix(std::uint64_t z) noexcept {
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31U);
}

/// A small seeded generator (SplitMix64). Eight bytes of state, so that each pixel
/// has its own and the order of the threads does not matter.
class Random {
 public:
  Random() = default;
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0) noexcept
      : state_(mix(seed + kStep) ^ mix(stream * kStep + 0x632be59bd9b4e019ULL)) {}

  [[nodiscard]] std::uint64_t next() noexcept { return mix(state_ += kStep); }
  /// In [0, 1).
  [[nodiscard]] double uniform() noexcept { return static_cast<double>(next() >> 11U) * 0x1.0p-53; }
  [[nodiscard]] double uniform(double low, double high) noexcept {
    return low + (high - low) * uniform();
  }
  /// Standard normal (Box and Muller).
  [[nodiscard]] double gaussian() noexcept {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }
  /// Waiting time of a Poisson process of unit rate.
  [[nodiscard]] double exponential() noexcept { return -std::log(1.0 - uniform()); }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ULL;
  std::uint64_t state_ = 0;
};

/// Streams of one seed: what is drawn for one purpose never shifts another.
enum class Stream : std::uint64_t {
  kFlight = 1,
  kTexture,
  kMovers,
  kImu,
  kFrames,
  kEvents,
  kFaults
};

[[nodiscard]] inline Random stream(std::uint64_t seed, Stream purpose,
                                   std::uint64_t index = 0) noexcept {
  return Random{seed, (static_cast<std::uint64_t>(purpose) << 48U) + index};
}

}  // namespace pled::sim
