#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "pled_vins/evaluation/trajectory.hpp"
#include "src/apps/ablation.hpp"
#include "src/apps/labelled_features.hpp"
#include "src/apps/opened_recording.hpp"
#include "src/apps/progress.hpp"

namespace pled::apps {

/// The middle and the worst of a figure over several runs. A run without one is worse than any.
struct MedianWorst {
  std::optional<double> median;
  std::optional<double> worst;
};

/// @param high_is_bad  false: the least is the worst
[[nodiscard]] MedianWorst median_and_worst(std::span<const std::optional<double>> runs,
                                           bool high_is_bad);

/// The rows of `score` of the weight that counts, image and event points in one.
struct AblationQuality {
  std::string_view kind;  ///< point or line
  std::string_view rows;  ///< all or used
  WeightJudgement judgement;
};

/// What one configuration made of a recording.
struct AblationResult {
  Ablation ablation;
  MedianWorst ate_m;     ///< over all starts; absent without truth
  MedianWorst coverage;  ///< the same
  /// Of the first start, which plays all of it: points all, used, lines all, used.
  std::array<AblationQuality, 4> quality;
};

/// Between the starts of one configuration.
inline constexpr double kAblationStartStep_s = 0.2;

/// Plays a recording as one configuration after the other has it.
class AblationRuns {
 public:
  /// `opened` outlives it; its settings are those that configurations start from.
  AblationRuns(OpenedRecording& opened, int starts);

  /// nullopt, with words, when a stream cannot be opened anew.
  [[nodiscard]] std::optional<AblationResult> play(const Ablation& ablation);
  /// Ends the progress bar and prints, once, what was wrong with the streams. False when one broke
  /// before its end.
  [[nodiscard]] bool finish();

 private:
  [[nodiscard]] double length_s(int start) const;

  OpenedRecording& opened_;
  AppConfig config_;
  int starts_;
  Trajectory truth_;
  Progress progress_;
  std::size_t configurations_ = 0;
  double played_s_ = 0.0;
  std::optional<RunEnd> whole_end_;  ///< of the first run, which played all
  const Health* health_ = nullptr;   ///< of the last run
};

}  // namespace pled::apps
