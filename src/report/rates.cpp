#include "src/report/rates.hpp"

#include <algorithm>

namespace pled::report {
namespace {

constexpr std::int64_t kLongestSpan_ns = 24LL * 3600 * RateCounter::kBin_ns;

std::int64_t median_interval_ns(std::span<const std::int64_t> stamps_ns) {
  std::vector<std::int64_t> intervals;
  for (std::size_t i = 1; i < stamps_ns.size(); ++i)
    if (stamps_ns[i] > stamps_ns[i - 1]) intervals.push_back(stamps_ns[i] - stamps_ns[i - 1]);
  if (intervals.empty()) return 0;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

}  // namespace

RateCounter::RateCounter(PlayedSpan span, std::int64_t gap_limit_ns)
    : span_(span), gap_limit_ns_(gap_limit_ns) {
  const std::int64_t length_ns =
      std::clamp<std::int64_t>(span.last_ns - span.first_ns, 0, kLongestSpan_ns);
  bins_.resize(static_cast<std::size_t>(length_ns / kBin_ns) + 1);
}

void RateCounter::add(std::int64_t stamp_ns) {
  if (stamp_ns < span_.first_ns || stamp_ns > span_.last_ns) return;
  const auto bin = static_cast<std::size_t>((stamp_ns - span_.first_ns) / kBin_ns);
  if (bin < bins_.size()) ++bins_[bin];
  const std::int64_t from_ns = last_ns_.value_or(span_.first_ns);
  if (stamp_ns - from_ns > gap_limit_ns_ && ++gap_count_ <= kMaxGaps)
    gaps_.push_back({since_s(from_ns, span_.first_ns), since_s(stamp_ns, from_ns)});
  last_ns_ = std::max(stamp_ns, from_ns);
}

Json RateCounter::to_json() const {
  return {{"per_s", bins_},
          {"gaps", gaps_},
          {"gap_count", gap_count_},
          {"gap_limit_s", rounded(static_cast<double>(gap_limit_ns_) * 1e-9, 6)}};
}

Json rates_of(std::span<const std::int64_t> stamps_ns, PlayedSpan span, double factor,
              std::int64_t at_least_ns) {
  const auto limit_ns =
      static_cast<std::int64_t>(factor * static_cast<double>(median_interval_ns(stamps_ns)));
  RateCounter counter(span, std::max(limit_ns, at_least_ns));
  for (const std::int64_t stamp_ns : stamps_ns) counter.add(stamp_ns);
  return counter.to_json();
}

}  // namespace pled::report
