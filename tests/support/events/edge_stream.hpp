#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "pled_vins/core/messages.hpp"

namespace pled::support {

/// What an edge_stream() is made of.
struct EdgeStreamOptions {
  int width_px = 240;
  int height_px = 180;
  std::size_t events = 400'000;
  double rate_hz = 2e6;
  std::uint64_t seed = 1;
  double noise = 0.1;  ///< share of events anywhere
  std::int64_t begin_us = 1'000'000;
};

/// Events of 40 straight edges of 100 pixels that cross the sensor at 100 to 300 px/s and come in
/// again on the other side, some events for each pixel they pass, and noise. The same number of
/// events whatever the sensor's size.
[[nodiscard]] inline std::vector<Event> edge_stream(const EdgeStreamOptions& options) {
  struct Edge {
    double x, y, along_x, along_y, speed_x, speed_y;
    Polarity polarity;
  };
  std::mt19937_64 random(options.seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double width = options.width_px;
  const double height = options.height_px;
  std::array<Edge, 40> edges{};
  for (Edge& e : edges) {
    const double angle = 6.283185307179586 * unit(random);
    const double speed = 100.0 + 200.0 * unit(random);
    e = {width * unit(random),
         height * unit(random),
         100.0 * std::cos(angle),
         100.0 * std::sin(angle),
         -speed * std::sin(angle),
         speed * std::cos(angle),
         unit(random) < 0.5 ? Polarity::kOff : Polarity::kOn};
  }
  const auto wrapped = [](double value, double size) {
    const double inside = value - size * std::floor(value / size);
    return static_cast<std::uint16_t>(std::min(inside, size - 1.0));
  };
  std::vector<Event> events(options.events);
  for (std::size_t i = 0; i < events.size(); ++i) {
    const double t_s = static_cast<double>(i) / options.rate_hz;
    Event& out = events[i];
    out.t.us = options.begin_us + static_cast<std::int64_t>(t_s * 1e6);
    if (unit(random) < options.noise) {
      out.x_px = wrapped(width * unit(random), width);
      out.y_px = wrapped(height * unit(random), height);
      out.polarity = unit(random) < 0.5 ? Polarity::kOff : Polarity::kOn;
      continue;
    }
    const Edge& e = edges[static_cast<std::size_t>(40.0 * unit(random))];
    const double s = unit(random);
    out.x_px = wrapped(e.x + s * e.along_x + t_s * e.speed_x, width);
    out.y_px = wrapped(e.y + s * e.along_y + t_s * e.speed_y, height);
    out.polarity = e.polarity;
  }
  return events;
}

}  // namespace pled::support
