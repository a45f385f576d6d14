#include "pled_vins/pipeline/latency_histogram.hpp"

#include <algorithm>
#include <cmath>

namespace pled {
namespace {

constexpr double kSmallestNs = 100.0;
constexpr double kLogRatio = 0.019802627296179712;  // ln 1.02

}  // namespace

void LatencyHistogram::add_ns(std::int64_t ns) noexcept {
  const std::int64_t value = std::max<std::int64_t>(ns, 0);
  std::size_t bin = 0;
  if (static_cast<double>(value) > kSmallestNs) {
    const double k = std::ceil(std::log(static_cast<double>(value) / kSmallestNs) / kLogRatio);
    bin = std::min(kBins - 1, static_cast<std::size_t>(k));
  }
  ++bins_[bin];
  ++count_;
  sum_ns_ += value;
  max_ns_ = std::max(max_ns_, value);
}

double LatencyHistogram::quantile_us(double q) const noexcept {
  if (count_ == 0) return 0.0;
  const double wanted = q * static_cast<double>(count_);
  std::uint64_t seen = 0;
  for (std::size_t k = 0; k < kBins; ++k) {
    seen += bins_[k];
    if (static_cast<double>(seen) >= wanted) {
      const double upper_ns = kSmallestNs * std::exp(kLogRatio * static_cast<double>(k));
      return std::min(upper_ns, static_cast<double>(max_ns_)) * 1e-3;
    }
  }
  return max_us();
}

}  // namespace pled
