#include "pled_vins/pipeline/event_admission.hpp"

#include <algorithm>

#include "pled_vins/core/check.hpp"

namespace pled {

void admit_settled(FrameMeasurement& frame) noexcept {
  for (PointMeasurement& p : frame.points)
    p.for_solver = p.kind != FeatureKind::kEventPoint || p.track_length >= kSettledSights;
}

void EventAdmission::decide(FrameMeasurement& frame, bool tracking) noexcept {
  // In the first frames no point can have been followed for long.
  std::uint32_t longest = 1;
  for (const PointMeasurement& p : frame.points)
    if (p.kind == FeatureKind::kImagePoint) longest = std::max(longest, p.track_length);
  const std::uint32_t needed = std::min(kSettled, longest);
  std::size_t settled = 0;
  for (const PointMeasurement& p : frame.points)
    if (p.kind == FeatureKind::kImagePoint && p.inlier && p.track_length >= needed) ++settled;
  const std::size_t enough = tracking ? kEnough : kEnoughToStart;
  std::size_t room = settled < enough ? enough - settled : 0;
  FixedVector<FeatureId, limits::kMaxPoints> kept;
  for (PointMeasurement& p : frame.points) {
    if (p.kind != FeatureKind::kEventPoint) continue;
    p.for_solver = false;
    if (p.track_length < kSettledSights) continue;
    const bool known = std::find(admitted_.begin(), admitted_.end(), p.id) != admitted_.end();
    p.for_solver = known || room > 0;
    if (!p.for_solver) continue;
    if (!known) --room;
    PLED_CHECK(kept.push_back(p.id));
  }
  admitted_ = kept;
}

}  // namespace pled
