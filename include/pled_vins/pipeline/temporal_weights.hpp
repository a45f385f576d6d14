#pragma once

#include "pled_vins/core/messages.hpp"
#include "pled_vins/reliability/config.hpp"

namespace pled {

/// w_EV of one point or line by each score: 1 at rest, 0 moving; kNoEvidence where it cannot say.
struct TemporalWeights {
  double motion = kNoEvidence;
  double paper = kNoEvidence;
  double count = kNoEvidence;

  [[nodiscard]] double of(TemporalScore score) const noexcept {
    switch (score) {
      case TemporalScore::kMotion: return motion;
      case TemporalScore::kPaper: return paper;
      case TemporalScore::kCount: return count;
    }
    return kNoEvidence;
  }
};

}  // namespace pled
