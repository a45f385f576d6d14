#include "pled_vins/reliability/entropy_recency.hpp"

#include <algorithm>
#include <cmath>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

constexpr std::size_t kBins = limits::kTimeBins;

/// Eq. (5). Its denominator vanishes only for (h, q) = (0, 1) or (1, 0), which no counts reach:
/// w_k lies strictly between w_min and 1.
double fuse(double h, double q) noexcept {
  const double both = h * q;
  const double sum = both + (1.0 - h) * (1.0 - q);
  return sum > 0.0 ? both / sum : 0.0;
}

}  // namespace

ScoreTables::ScoreTables(double alpha) noexcept : min_weight_(std::exp(-alpha)) {
  PLED_CHECK(alpha > 0.0);
  for (std::size_t k = 0; k < kBins; ++k) {
    const double middle = (static_cast<double>(k) + 0.5) / static_cast<double>(kBins);
    weights_[k] = std::exp(-alpha * (1.0 - middle));
  }
  for (std::size_t n = 1; n < log_n_.size(); ++n) log_n_[n] = std::log(static_cast<double>(n));
  for (std::size_t c = 1; c < c_log_c_.size(); ++c)
    c_log_c_[c] = static_cast<double>(c) * log_n_[c];
}

PixelScore ScoreTables::score(const BinCounts& counts, ScoreForm form) const noexcept {
  return form == ScoreForm::kPaper ? paper_score(counts) : clean_score(counts);
}

double ScoreTables::recency(const BinCounts& counts, ScoreForm form) const noexcept {
  std::uint32_t n = 0;
  for (const std::uint8_t c : counts) n += c;
  const bool paper = form == ScoreForm::kPaper;
  if (n == 0 && !paper) return 0.0;
  const double epsilon = paper ? kPaperEpsilon : 0.0;
  double mean = 0.0;
  for (std::size_t k = 0; k < kBins; ++k) mean += weights_[k] * (counts[k] / (n + epsilon));
  const double q = (mean - min_weight_) / (1.0 - min_weight_ + epsilon);
  return paper ? q : std::clamp(q, 0.0, 1.0);  // against rounding
}

PixelScore ScoreTables::clean_score(const BinCounts& counts) const noexcept {
  PixelScore out;
  double sum_c_log_c = 0.0;
  for (const std::uint8_t c : counts) {
    out.n += c;
    sum_c_log_c += c_log_c_[c];
  }
  if (out.n == 0) return out;
  // -sum c/n log(c/n) = log n - sum (c log c) / n
  const double h = (log_n_[out.n] - sum_c_log_c / out.n) / log_n_[kBins];
  out.h = std::clamp(h, 0.0, 1.0);  // against rounding
  out.q = recency(counts, ScoreForm::kClean);
  out.s = fuse(out.h, out.q);
  return out;
}

PixelScore ScoreTables::paper_score(const BinCounts& counts) const noexcept {
  PixelScore out;
  for (const std::uint8_t c : counts) out.n += c;
  double entropy = 0.0;
  for (const std::uint8_t c : counts) {
    const double p = c / (out.n + kPaperEpsilon);
    entropy -= p * std::log(p + kPaperEpsilon);
  }
  out.h = entropy / log_n_[kBins];
  out.q = recency(counts, ScoreForm::kPaper);
  out.s = fuse(out.h, out.q);
  return out;
}

}  // namespace pled
