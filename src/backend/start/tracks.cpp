#include "src/backend/start/tracks.hpp"

#include <algorithm>
#include <cmath>

namespace pled::start {

std::size_t Tracks::count_ids(const StartFrames& frames) noexcept {
  std::size_t n = 0;
  for (const FrameMeasurement& frame : frames)
    for (const PointMeasurement& point : frame.points) ids_[n++] = {point.id, 1};
  const auto by_id = [](const Count& a, const Count& b) { return a.id < b.id; };
  std::sort(ids_.begin(), ids_.begin() + static_cast<std::ptrdiff_t>(n), by_id);
  std::size_t distinct = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (distinct > 0 && ids_[distinct - 1].id == ids_[i].id)
      ++ids_[distinct - 1].count;
    else
      ids_[distinct++] = ids_[i];
  }
  return distinct;
}

void Tracks::build(const StartFrames& frames, std::size_t min_sights) noexcept {
  const std::size_t distinct = count_ids(frames);
  const auto begin = ids_.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(distinct);
  std::sort(begin, end, [](const Count& a, const Count& b) {
    return a.count != b.count ? a.count > b.count : a.id < b.id;
  });
  size_ = std::min(distinct, kMaxTracks);
  while (size_ > 0 && ids_[size_ - 1].count < min_sights) --size_;
  std::sort(begin, begin + static_cast<std::ptrdiff_t>(size_),
            [](const Count& a, const Count& b) { return a.id < b.id; });
  for (std::size_t i = 0; i < size_; ++i) ids_[i].count = 0;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    for (const PointMeasurement& point : frames[f].points) {
      const auto last = begin + static_cast<std::ptrdiff_t>(size_);
      const auto at = std::lower_bound(begin, last, point.id,
                                       [](const Count& c, FeatureId id) { return c.id < id; });
      if (at == last || at->id != point.id || at->count == kMaxFrames) continue;
      if (!std::isfinite(point.bearing_xy[0]) || !std::isfinite(point.bearing_xy[1])) continue;
      const auto i = static_cast<std::size_t>(at - begin);
      cameras_[i] = point.camera;
      sights_[i * kMaxFrames + at->count++] = {
          static_cast<std::uint32_t>(f),
          {static_cast<float>(point.bearing_xy[0]), static_cast<float>(point.bearing_xy[1])}};
    }
  }
}

}  // namespace pled::start
