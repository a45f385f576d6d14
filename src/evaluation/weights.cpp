#include "pled_vins/evaluation/weights.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace pled {
namespace {

/// Mann-Whitney: the mean rank of the rows at rest, ties at their middle.
double area_under_curve(std::vector<LabelledWeight>& rows, double n_static, double n_dynamic) {
  std::sort(rows.begin(), rows.end(),
            [](const LabelledWeight& a, const LabelledWeight& b) { return a.w < b.w; });
  double ranks = 0.0;
  for (std::size_t i = 0; i < rows.size();) {
    std::size_t end = i;
    while (end < rows.size() && rows[end].w == rows[i].w) ++end;
    const double middle = 0.5 * (static_cast<double>(i) + static_cast<double>(end - 1)) + 1.0;
    for (; i < end; ++i)
      if (!rows[i].is_moving) ranks += middle;
  }
  return (ranks - 0.5 * n_static * (n_static + 1.0)) / (n_static * n_dynamic);
}

}  // namespace

WeightQuality judge_weights(std::span<const LabelledWeight> rows) {
  std::vector<LabelledWeight> known;
  WeightQuality q;
  double w_static = 0.0;
  double w_dynamic = 0.0;
  for (const LabelledWeight& row : rows) {
    if (std::isnan(row.w)) continue;
    known.push_back(row);
    (row.is_moving ? w_dynamic : w_static) += row.w;
    ++(row.is_moving ? q.n_dynamic : q.n_static);
  }
  const auto n_static = static_cast<double>(q.n_static);
  const auto n_dynamic = static_cast<double>(q.n_dynamic);
  if (!known.empty()) q.mae = (n_static - w_static + w_dynamic) / (n_static + n_dynamic);
  if (q.n_static > 0) q.mean_static = w_static / n_static;
  if (q.n_static == 0 || q.n_dynamic == 0) return q;
  q.mae_balanced = 0.5 * (1.0 - w_static / n_static + w_dynamic / n_dynamic);
  if (w_dynamic > 0.0) q.w_ratio = (w_static / n_static) / (w_dynamic / n_dynamic);
  q.auc = area_under_curve(known, n_static, n_dynamic);
  return q;
}

}  // namespace pled
