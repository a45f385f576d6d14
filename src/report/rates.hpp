#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/report/json.hpp"

namespace pled::report {

/// The part of a recording that was played, on its own clock.
struct PlayedSpan {
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
};

/// How many items of a stream came in each second of the span, and where none came for
/// longer than a limit.
class RateCounter {
 public:
  static constexpr std::int64_t kBin_ns = 1'000'000'000;
  static constexpr std::size_t kMaxGaps = 200;  ///< listed; more are only counted

  RateCounter(PlayedSpan span, std::int64_t gap_limit_ns);

  /// In the order of time; what lies outside the span is passed over.
  void add(std::int64_t stamp_ns);
  /// {"per_s": [...], "gaps": [[begin_s, length_s], ...], "gap_count", "gap_limit_s"}.
  [[nodiscard]] Json to_json() const;

 private:
  PlayedSpan span_;
  std::int64_t gap_limit_ns_;
  std::vector<std::uint64_t> bins_;
  std::optional<std::int64_t> last_ns_;
  Json gaps_ = Json::array();
  std::uint64_t gap_count_ = 0;
};

/// The rates of stamps that are all known. A gap is longer than `factor` median
/// intervals and than `at_least_ns`.
[[nodiscard]] Json rates_of(std::span<const std::int64_t> stamps_ns, PlayedSpan span, double factor,
                            std::int64_t at_least_ns);

}  // namespace pled::report
