#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace pled {

/// Durations of one stage in fixed memory: quantiles to 2 %, maximum exact.
class LatencyHistogram {
 public:
  /// Counts one duration in nanoseconds; negative ones count as 0.
  void add_ns(std::int64_t ns) noexcept;

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  /// Smallest recorded duration that at least the share `q` in (0, 1] does not
  /// exceed, us; 0 when nothing was counted. Off by at most 2 %.
  [[nodiscard]] double quantile_us(double q) const noexcept;
  [[nodiscard]] double max_us() const noexcept { return static_cast<double>(max_ns_) * 1e-3; }
  [[nodiscard]] double mean_us() const noexcept {
    return count_ == 0 ? 0.0 : static_cast<double>(sum_ns_) * 1e-3 / static_cast<double>(count_);
  }

 private:
  // Bin k holds (100 ns * 1.02^(k-1), 100 ns * 1.02^k]; 1200 bins reach 2000 s.
  static constexpr std::size_t kBins = 1200;
  std::array<std::uint32_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  std::int64_t sum_ns_ = 0;
  std::int64_t max_ns_ = 0;
};

}  // namespace pled
