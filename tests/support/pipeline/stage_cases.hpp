#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include "support/pipeline/stage_run.hpp"

namespace pled::support {

inline constexpr std::int64_t kStart_us = 1 << 20;  ///< the swing starts at 0: it is fast by then

inline EventStageConfig config_of(EventPicture picture, bool keep_map = false) {
  EventStageConfig config;
  config.events.picture = picture;
  config.events.max_points = 60;
  config.keep_map = keep_map;
  return config;
}

/// Turns and goes sideways at once: at most 0.67 rad/s and 0.28 m/s before a wall at 1 m.
inline SwingingBody swing() { return {{0.15, 0.25, 0.2}, {0.12, 0.08, 0.02}, 0.6}; }

inline constexpr std::array kPictures{EventPicture::kBrightness, EventPicture::kTimeSurface};

inline void check_same(const FrameMeasurement& a, const FrameMeasurement& b) {
  REQUIRE(a.points.size() == b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    const PointMeasurement& p = a.points[i];
    const PointMeasurement& q = b.points[i];
    CHECK(p.id == q.id);
    CHECK(p.raw_px == q.raw_px);
    CHECK(p.bearing_xy == q.bearing_xy);
    CHECK(p.track_length == q.track_length);
  }
}

inline std::vector<Event> with_stamps_moved(std::vector<Event> events, std::int64_t by_us) {
  for (Event& e : events) e.t.us += by_us;
  return events;
}

}  // namespace pled::support
