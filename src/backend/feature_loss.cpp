#include "pled_vins/backend/feature_loss.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pled_vins/backend/adaptive_fusion.hpp"

namespace pled {
namespace {

/// DynaVINS leaves shorter tracks alone.
constexpr std::size_t kFewestOfDynavins = 4;

constexpr double kMinWeight = 0.25;  ///< below, a landmark is taken to be wrong
constexpr double kRests = 0.8;       ///< of w_temporal
/// As many as the motion cue looks back on: by then it has forgotten the motion.
constexpr std::uint32_t kFramesAtRest = limits::kCueFrames + 1;

/// Squared residuals as the weight's loss sees them. Ours: Cauchy's loss of each, so that one wild
/// sighting does not speak for the whole track; as published: themselves.
class InnerLoss {
 public:
  InnerLoss(const FactorSettings& settings, std::span<const double> squared) noexcept
      : count_(std::min(squared.size(), losses_.size())) {
    const double c2 = settings.robust_scale * settings.robust_scale;
    const bool plain = as_published(settings.robust.mode);
    for (std::size_t k = 0; k < count_; ++k)
      losses_[k] = plain ? squared[k] : c2 * std::log1p(squared[k] / c2);
  }
  [[nodiscard]] std::span<const double> span() const noexcept {
    return std::span(losses_).first(count_);
  }

 private:
  std::array<double, limits::kWindowStates> losses_;
  std::size_t count_;
};

RobustEvidence evidence_of(const FactorSettings& settings, const InnerLoss& inner,
                           const Reliability& reliability) noexcept {
  RobustEvidence out;
  out.squared = inner.span();
  out.previous = reliability.previous;
  out.rounds = reliability.rounds + 1;
  if (settings.fusion.mode == FusionMode::kPrior) {
    out.temporal = reliability.temporal;
    out.lambda_z = settings.fusion.lambda_z;
  }
  return out;
}

}  // namespace

void weigh(const FactorSettings& settings, std::span<const double> squared,
           Reliability& reliability) noexcept {
  if (settings.robust.mode == RobustMode::kDynavins && squared.size() < kFewestOfDynavins) {
    reliability.w = reliability.w_geometric = 1.0;
    return;
  }
  const InnerLoss inner(settings, squared);
  RobustEvidence evidence = evidence_of(settings, inner, reliability);
  reliability.w = robust_weight(settings.robust, evidence).value_or(0.0);
  evidence.temporal = kNoEvidence;
  reliability.w_geometric = robust_weight(settings.robust, evidence).value_or(0.0);
}

void conclude(const FactorSettings& settings, bool is_line, Reliability& reliability) noexcept {
  if (settings.fusion.mode == FusionMode::kPaper)
    reliability.w =
        is_line ? paper_line_fusion(reliability.w, reliability.temporal, reliability.alpha_line)
                : paper_point_fusion(reliability.w, reliability.temporal, settings.fusion);
  reliability.previous = reliability.w;
  ++reliability.rounds;
}

void note_time(double w_temporal, Reliability& reliability) noexcept {
  if (std::isnan(w_temporal)) return;
  reliability.temporal = w_temporal;
  reliability.at_rest = w_temporal > kRests ? reliability.at_rest + 1 : 0;
}

bool parked_again(double w_temporal, const Reliability& reliability) noexcept {
  return w_temporal > kRests && reliability.at_rest + 1 >= kFramesAtRest;
}

bool agrees(const FactorSettings& settings, double mean_cauchy_weight) noexcept {
  return as_published(settings.robust.mode) || mean_cauchy_weight > kMinWeight;
}

double feature_cost(const FactorSettings& settings, std::span<const double> squared,
                    const Reliability& reliability) noexcept {
  const InnerLoss inner(settings, squared);
  return 0.5 * settings.sight_gain *
         robust_loss(settings.robust, evidence_of(settings, inner, reliability), reliability.w);
}

double sight_loss(const FactorSettings& settings, double squared, double w) noexcept {
  const InnerLoss inner(settings, std::span(&squared, 1));
  if (settings.robust.mode != RobustMode::kDynavins)
    return settings.sight_gain * w * w * inner.span()[0];
  const double r = w * std::sqrt(squared);  // Huber's loss with scale 1
  return settings.sight_gain * (r <= 1.0 ? r * r : 2.0 * r - 1.0);
}

double sight_weight(const FactorSettings& settings, double squared, double w) noexcept {
  if (as_published(settings.robust.mode))
    return settings.sight_gain * observation_gain(settings.robust, squared, w);
  return settings.sight_gain * observation_gain(settings.robust, squared, w) *
         cauchy_weight(squared, settings.robust_scale);
}

}  // namespace pled
