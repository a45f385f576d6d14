#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace pled {

/// What was believed of one feature in one frame, and what it was.
struct LabelledWeight {
  double w = 0.0;          ///< 1: at rest, 0: moving
  bool is_moving = false;  ///< label
};

/// How well weights tell moving features from those at rest. What cannot be said, for want of one
/// class, is absent.
struct WeightQuality {
  /// Chance that of a feature at rest and a moving one the first has the higher weight; ties count
  /// one half. 0.5 is a coin, below is worse than one.
  std::optional<double> auc;
  std::optional<double> mae;  ///< mean of |w - y|, y = 1 at rest, 0 moving
  /// Mean of the two classes' own MAE: a constant weight gets 0.5.
  std::optional<double> mae_balanced;
  /// Mean weight of those at rest over that of the moving ones, pooled over all rows. Absent when
  /// the latter is 0.
  std::optional<double> w_ratio;
  std::optional<double> mean_static;  ///< weight of those at rest
  std::size_t n_static = 0;
  std::size_t n_dynamic = 0;

  /// The MAE of a weight of 1 on the same rows: the share of the moving ones. Balanced it is 0.5.
  [[nodiscard]] std::optional<double> mae_of_one() const noexcept {
    const std::size_t n = n_static + n_dynamic;
    if (n == 0) return std::nullopt;
    return static_cast<double>(n_dynamic) / static_cast<double>(n);
  }
};

/// Rows whose weight is NaN (no evidence) are left out. Cost: n log n, allocates.
[[nodiscard]] WeightQuality judge_weights(std::span<const LabelledWeight> rows);

}  // namespace pled
