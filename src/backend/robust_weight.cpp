#include "pled_vins/backend/robust_weight.hpp"

#include <algorithm>
#include <cmath>

namespace pled {
namespace {

/// Ours: ten observations know a weight as well as more do; beyond, a track that starts to move
/// would be believed for a second.
constexpr std::size_t kMostMomentum = 10;

/// rho(w) of the parabolas: w^2 S and one pull on w each towards 1, w~ and z.
struct Parabola {
  double squared = 0.0;  ///< S
  double regulariser = 0.0;
  double momentum = 0.0;
  double previous = 0.0;
  double prior = 0.0;
  double temporal = 0.0;  ///< 0 when nothing is known: its pull is 0 then

  [[nodiscard]] double minimiser() const noexcept {
    return (regulariser + momentum * previous + prior * temporal) /
           (squared + regulariser + momentum + prior);
  }
  [[nodiscard]] double loss(double w) const noexcept {
    const double to_one = 1.0 - w, to_previous = previous - w, to_temporal = temporal - w;
    return w * w * squared + regulariser * to_one * to_one + momentum * to_previous * to_previous +
           prior * to_temporal * to_temporal;
  }
};

double sum(std::span<const double> squared) noexcept {
  double s = 0.0;
  for (const double x : squared) s += x;
  return s;
}

Parabola parabola(const RobustWeightConfig& c, const RobustEvidence& e) noexcept {
  const std::size_t m = e.squared.size();
  const bool paper = c.mode == RobustMode::kPaper;
  const bool knows_time = !paper && !std::isnan(e.temporal);
  const double each = paper ? 1.0 : static_cast<double>(m);
  const auto n = static_cast<double>(paper ? m : std::min(m, kMostMomentum));
  return {.squared = sum(e.squared),
          .regulariser = each * c.lambda_w,
          .momentum = each * c.lambda_m * n * n,
          .previous = e.previous,
          .prior = knows_time ? each * e.lambda_z : 0.0,
          .temporal = knows_time ? e.temporal : 0.0};
}

/// A residual a w - b under Huber's loss with scale 1.
struct HuberTerm {
  double a = 0.0;
  double b = 0.0;

  [[nodiscard]] double loss(double w) const noexcept {
    const double r = std::abs(a * w - b);
    return r <= 1.0 ? r * r : 2.0 * r - 1.0;
  }
  /// Half of d(loss) / dw: never falls, straight between (b - 1) / a and (b + 1) / a, constant
  /// outside.
  [[nodiscard]] double half_slope(double w) const noexcept {
    return a * std::clamp(a * w - b, -1.0, 1.0);
  }
};

/// All terms of DynaVINS' loss, as they are needed.
class HuberSum {
 public:
  HuberSum(const RobustWeightConfig& c, const RobustEvidence& e) noexcept : squared_(e.squared) {
    const double momentum = c.lambda_m * static_cast<double>(e.rounds);
    regulariser_ = {c.lambda_w, c.lambda_w};
    momentum_ = {momentum, momentum * e.previous};
  }

  template <typename Visit>
  void each(const Visit& visit) const noexcept {
    for (const double s : squared_) visit(HuberTerm{std::sqrt(s), 0.0});
    visit(regulariser_);
    visit(momentum_);
  }
  [[nodiscard]] double half_slope(double w) const noexcept {
    double slope = 0.0;
    each([&](const HuberTerm& t) { slope += t.half_slope(w); });
    return slope;
  }

 private:
  std::span<const double> squared_;
  HuberTerm regulariser_, momentum_;
};

/// The zero of the slope in [0, 1]: the ends of the terms' straight pieces close in on the piece
/// that holds it.
double minimiser(const HuberSum& terms) noexcept {
  double low = 0.0, high = 1.0;
  if (terms.half_slope(low) >= 0.0) return low;
  if (terms.half_slope(high) <= 0.0) return high;
  terms.each([&](const HuberTerm& t) {
    if (!(t.a > 0.0)) return;
    for (const double end : {(t.b - 1.0) / t.a, (t.b + 1.0) / t.a}) {
      if (!(end > low && end < high)) continue;
      (terms.half_slope(end) <= 0.0 ? low : high) = end;
    }
  });
  const double below = terms.half_slope(low);
  const double above = terms.half_slope(high);
  return low + (high - low) * (-below / (above - below));
}

bool usable(const RobustEvidence& e) noexcept {
  if (e.squared.empty() || !std::isfinite(e.previous) || std::isinf(e.temporal)) return false;
  if (!std::isfinite(e.lambda_z) || e.lambda_z < 0.0) return false;
  for (const double s : e.squared) {
    if (!(s >= 0.0)) return false;
  }
  return std::isfinite(sum(e.squared));
}

}  // namespace

std::optional<double> robust_weight(const RobustWeightConfig& config,
                                    const RobustEvidence& evidence) noexcept {
  if (check(config).key || !usable(evidence)) return std::nullopt;
  switch (config.mode) {
    case RobustMode::kNone: return 1.0;
    case RobustMode::kDynavins: return minimiser(HuberSum(config, evidence));
    case RobustMode::kPerObservation:
    case RobustMode::kPaper: break;
  }
  return std::clamp(parabola(config, evidence).minimiser(), 0.0, 1.0);
}

double robust_loss(const RobustWeightConfig& config, const RobustEvidence& evidence,
                   double w) noexcept {
  if (config.mode == RobustMode::kNone) return w * w * sum(evidence.squared);
  if (config.mode != RobustMode::kDynavins) return parabola(config, evidence).loss(w);
  double loss = 0.0;
  HuberSum(config, evidence).each([&](const HuberTerm& t) { loss += t.loss(w); });
  return loss;
}

double observation_gain(const RobustWeightConfig& config, double squared, double w) noexcept {
  if (config.mode != RobustMode::kDynavins) return w * w;
  const double r = w * std::sqrt(squared);
  return r <= 1.0 ? w * w : w * w / r;
}

}  // namespace pled
