#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "pled_vins/events/active_surface.hpp"

namespace pled::support {

/// The active surface as its definition says, with full stamps and no tricks, for streams in time
/// order whose events lie on the sensor.
class SurfaceReference {
 public:
  struct Pixel {
    std::optional<std::int64_t> latest_us[2];
    std::optional<std::int64_t> filtered_us[2];
    std::optional<int> last_polarity;
    double tank_us = 0.0;
  };

  SurfaceReference(const EventConfig& config, int width_px, int height_px)
      : config_(config), width_px_(width_px) {
    pixels_.resize(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px));
  }

  EventVerdict insert(const Event& e) {
    Pixel& pixel =
        pixels_[static_cast<std::size_t>(e.y_px) * static_cast<std::size_t>(width_px_) + e.x_px];
    const int p = e.polarity == Polarity::kOn ? 1 : 0;
    const std::int64_t t = e.t.us;
    const bool known = pixel.last_polarity.has_value();
    const std::int64_t last = std::max(pixel.latest_us[0].value_or(t - (std::int64_t{1} << 40)),
                                       pixel.latest_us[1].value_or(t - (std::int64_t{1} << 40)));
    const double period_us = 1e6 / config_.hot_rate_hz;
    const double full_us = period_us * config_.hot_burst;
    pixel.tank_us = std::max(0.0, pixel.tank_us - static_cast<double>(t - last)) + period_us;
    // Flip: the other polarity fired later than this one; of two with one stamp, the later in the
    // stream did.
    const bool flip = known && *pixel.last_polarity != p;
    const bool first = !pixel.latest_us[p].has_value();
    const bool rested =
        first || static_cast<double>(t - *pixel.latest_us[p]) > 1e3 * config_.redundant_ms;
    pixel.latest_us[p] = t;
    pixel.last_polarity = p;
    if (pixel.tank_us > full_us) {
      pixel.tank_us = std::min(pixel.tank_us, 2.0 * full_us);
      return EventVerdict::kHot;
    }
    if (!(flip || rested)) return EventVerdict::kRedundant;
    pixel.filtered_us[p] = t;
    accepted.push_back(e);
    return EventVerdict::kAccepted;
  }

  [[nodiscard]] const Pixel& at(int y_px, int x_px) const {
    return pixels_[static_cast<std::size_t>(y_px) * static_cast<std::size_t>(width_px_) +
                   static_cast<std::size_t>(x_px)];
  }

  std::vector<Event> accepted;

 private:
  EventConfig config_;
  int width_px_;
  std::vector<Pixel> pixels_;
};

}  // namespace pled::support
