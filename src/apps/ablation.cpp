#include "src/apps/ablation.hpp"

namespace pled::apps {
namespace {

/// Of the paper and of DynaVINS on VIODE, the paper's as printed in the loss.
constexpr double kPublishedLambdaW = 2.0;
constexpr double kPublishedLambdaM = 0.2;

FusionMode fusion_of(const Ablation& ablation, FusionMode configured) noexcept {
  if (!ablation.temporal) return FusionMode::kNone;
  if (ablation.method != WeightMethod::kDefault) return FusionMode::kPaper;
  return configured == FusionMode::kNone ? FusionConfig{}.mode : configured;
}

}  // namespace

std::string_view method_name(const Ablation& ablation) noexcept {
  switch (ablation.method) {
    case WeightMethod::kNone: return "none";
    case WeightMethod::kDefault: return "default";
    case WeightMethod::kPaper: return "paper";
    case WeightMethod::kDynavins: return "dynavins";
  }
  return {};
}

std::string_view evidence_name(const Ablation& ablation) noexcept {
  if (ablation.method == WeightMethod::kNone) return "none";
  return ablation.temporal ? "geometric+temporal" : "geometric";
}

std::string_view features_name(const Ablation& ablation) noexcept {
  return ablation.lines ? "points+lines" : "points";
}

AppConfig ablated(AppConfig config, const Ablation& ablation) {
  RobustWeightConfig& robust = config.backend.robust;
  FusionConfig& fusion = config.backend.fusion;
  fusion.mode = fusion_of(ablation, fusion.mode);
  switch (ablation.method) {
    case WeightMethod::kNone: robust.mode = RobustMode::kNone; break;
    case WeightMethod::kDefault: break;
    case WeightMethod::kPaper:
      robust = {RobustMode::kPaper, kPublishedLambdaW, kPublishedLambdaM};
      config.reliability.score = TemporalScore::kPaper;
      break;
    case WeightMethod::kDynavins:
      robust = {RobustMode::kDynavins, kPublishedLambdaW, kPublishedLambdaM};
      break;
  }
  if (ablation.method != WeightMethod::kDefault) {
    fusion.alpha0 = FusionConfig{}.alpha0;
    fusion.tau = FusionConfig{}.tau;
  }
  if (!ablation.lines)
    config.lines.source = LineSource::kNone;
  else if (config.lines.source == LineSource::kNone)
    config.lines.source = LineStageConfig{}.source;
  return config;
}

}  // namespace pled::apps
