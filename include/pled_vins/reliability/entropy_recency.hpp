#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "pled_vins/core/limits.hpp"
#include "pled_vins/reliability/bin_counters.hpp"

namespace pled {

/// The entropy-recency score of one pixel (or of a pool of them). With n = 0 there is no evidence,
/// whatever s says.
struct PixelScore {
  double h = 0.0;       ///< normalised entropy, eq. (2), in [0, 1]
  double q = 0.0;       ///< recency, eq. (3), in [0, 1]
  double s = 0.0;       ///< their fusion, eq. (5), in [0, 1]: 1 is what the paper calls moving
  std::uint32_t n = 0;  ///< events behind it
};

enum class ScoreForm : std::uint8_t {
  /// Without epsilon, by tables. A pixel without events has (h, q, s) = (0, 0, 0); all three stay
  /// in [0, 1].
  kClean,
  /// As printed, epsilon in p_k, in the logarithm and under q; nothing is held in its range, so a
  /// pixel without events has q = -w_min / (1 - w_min + epsilon), below 0. The paper says "a small
  /// positive constant"; ours is kPaperEpsilon.
  kPaper,
};

inline constexpr double kPaperEpsilon = 1e-9;

/// Turns a pixel's counts into its score:
///   h = -1/log B * sum p_k log p_k,             p_k = c_k / n                      eq. (2)
///   q = (sum w_k p_k - w_min) / (1 - w_min),    w_min = exp(-alpha)                eq. (3)
///   w_k = exp(-alpha (1 - (k + 0.5) / B)),      k = 0 oldest ... B-1 newest        eq. (4)
///   s = h q / (h q + (1 - h)(1 - q))                                               eq. (5)
/// For every alpha > 0, s > 1/2 exactly when h + q > 1. Source: paper, section "Entropy-Recency
/// Score Map".
class ScoreTables {
 public:
  /// @param alpha  > 0
  explicit ScoreTables(double alpha) noexcept;

  /// Cost: 2 table reads a bin in the clean form, a logarithm a bin in the paper's.
  [[nodiscard]] PixelScore score(const BinCounts& counts,
                                 ScoreForm form = ScoreForm::kClean) const noexcept;

  /// q of the score alone, eq. (3); of a pixel without events 0 in the clean form.
  [[nodiscard]] double recency(const BinCounts& counts,
                               ScoreForm form = ScoreForm::kClean) const noexcept;

  /// w_k of eq. (4).
  [[nodiscard]] double weight(std::size_t k) const noexcept { return weights_[k]; }

 private:
  [[nodiscard]] PixelScore clean_score(const BinCounts& counts) const noexcept;
  [[nodiscard]] PixelScore paper_score(const BinCounts& counts) const noexcept;

  static constexpr std::size_t kMaxCount = std::numeric_limits<std::uint8_t>::max();

  std::array<double, limits::kTimeBins> weights_{};
  double min_weight_;
  std::array<double, kMaxCount + 1> c_log_c_{};
  std::array<double, limits::kTimeBins * kMaxCount + 1> log_n_{};
};

/// w_EV of a point: 1 for what stands still. Paper, section "Temporal Reliability Estimation".
[[nodiscard]] constexpr double temporal_reliability(const PixelScore& score) noexcept {
  return 1.0 - score.s;
}

}  // namespace pled
