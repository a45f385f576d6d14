#pragma once

#include <cstddef>

#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/frontend/point_track.hpp"

namespace pled {

/// Without frames: for_solver of every event point that has settled.
void admit_settled(FrameMeasurement& frame) noexcept;

/// Decides which event points the solver gets. Ours: where frames show enough points for long
/// enough, event points, which err five to ten times as much (src/events/README.md), add cost and
/// little else; they come in where frames lose theirs. One that was
/// admitted stays until it is lost, so that its track is whole.
class EventAdmission {
 public:
  /// With so many image points that have been followed for kSettled frames nothing is admitted.
  static constexpr std::size_t kEnough = 60;
  static constexpr std::uint32_t kSettled = 4;
  /// The same before the estimator has started: the scale of a start asks for exact points.
  static constexpr std::size_t kEnoughToStart = 30;

  /// Sets for_solver of each event point; image points come before them.
  void decide(FrameMeasurement& frame, bool tracking) noexcept;
  void reset() noexcept { admitted_.clear(); }

 private:
  FixedVector<FeatureId, limits::kMaxPoints> admitted_;
};

}  // namespace pled
