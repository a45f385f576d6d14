#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/sim/options.hpp"
#include "src/sim/random.hpp"

namespace pled::sim {

/// One instant of what every pixel sees: linear intensity, row-major.
struct Exposure {
  double t_s = 0.0;
  std::span<const float> radiance;
};

/// The pixels of an event camera. Each remembers the log intensity of its last event
/// and fires when the present one is a threshold away; between two exposures the log
/// intensity is linear in time. After an event a pixel rests for the refractory time
/// and takes what it sees at the end of it as its new reference.
///
/// As v2e (Hu, Liu, Delbruck, 2021) has it: the photoreceptor is a low pass whose corner falls with
/// the light; the reference leaks away, which gives slow ON events; shot noise is four times as
/// frequent in the dark as in full light; a few hot pixels fire by themselves.
///
/// Rows are independent: different rows may be advanced from different threads, and
/// what comes out does not depend on how.
class EventModel {
 public:
  EventModel(int width_px, int height_px, const EventOptions& options, std::uint64_t seed);

  /// Every pixel at rest at `first`, at a random place between its thresholds.
  void start(const Exposure& first);
  /// Takes row y through `exposures` (times increasing, after the last one seen) and
  /// appends its events, ordered by pixel, then time.
  void advance_row(int y, std::span<const Exposure> exposures, std::vector<Event>& out);
  /// Tells that all rows have been taken up to `t_s`.
  void advanced_to(double t_s) noexcept { t_s_ = t_s; }

  /// log(radiance + dark): dark current keeps black finite.
  [[nodiscard]] static float log_intensity(float radiance) noexcept;
  [[nodiscard]] double threshold_on(int y, int x) const noexcept {
    return static_cast<double>(pixel(y, x).on);
  }
  [[nodiscard]] double threshold_off(int y, int x) const noexcept {
    return static_cast<double>(pixel(y, x).off);
  }

 private:
  struct Pixel {
    Random random;
    double noise_left = 0.0;      // until its next spurious event, in mean waiting times
    double rests_until_s = -1.0;  // negative: not resting
    float on = 0.0F, off = 0.0F;  // thresholds, > 0
    float reference = 0.0F;
    float last = 0.0F;   // filtered log intensity at the last exposure
    float input = 0.0F;  // the same before the filter
    bool hot = false;
  };
  /// Linear piece of one pixel's log intensity.
  struct Piece {
    double t0_s, t1_s;
    double from, slope;
    double noise_hz;
    [[nodiscard]] double at(double t_s) const noexcept { return from + slope * (t_s - t0_s); }
  };
  [[nodiscard]] const Pixel& pixel(int y, int x) const noexcept {
    return pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px_) +
                   static_cast<std::size_t>(x)];
  }
  [[nodiscard]] double noise_hz(const Pixel& p, float radiance) const noexcept;
  struct Crossing {
    double t_s;
    bool on;
  };
  [[nodiscard]] float filtered(Pixel& p, float radiance, double dt_s) const noexcept;
  [[nodiscard]] static Crossing next_crossing(const Pixel& p, const Piece& piece,
                                              double t_s) noexcept;
  void advance_pixel(Pixel& p, const Piece& piece, Event event, std::vector<Event>& out) const;

  int width_px_;
  EventOptions options_;
  std::vector<Pixel> pixels_;
  double t_s_ = 0.0;
};

/// Puts events in the order in which a sensor sends them: time, row, column.
void sort_as_sent(std::vector<Event>& events);

}  // namespace pled::sim
