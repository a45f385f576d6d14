#include "src/sim/event_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

namespace pled::sim {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr float kDark = 0.02F;
constexpr double kLowestThreshold = 0.02;
constexpr double kLowestBandwidthShare = 0.05;

}  // namespace

EventModel::EventModel(int width_px, int height_px, const EventOptions& options, std::uint64_t seed)
    : width_px_(width_px), options_(options) {
  pixels_.resize(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px));
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    Pixel& p = pixels_[i];
    p.random = stream(seed, Stream::kEvents, i);
    const double sigma = options.mismatch * options.threshold;
    const double on = options.threshold + sigma * p.random.gaussian();
    const double off = options.threshold + sigma * p.random.gaussian();
    p.on = static_cast<float>(std::max(kLowestThreshold, on));
    p.off = static_cast<float>(std::max(kLowestThreshold, off));
    p.noise_left = p.random.exponential();
    p.hot = p.random.uniform() < options.hot_share;
  }
}

float EventModel::log_intensity(float radiance) noexcept { return std::log(radiance + kDark); }

void EventModel::start(const Exposure& first) {
  t_s_ = first.t_s;
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    Pixel& p = pixels_[i];
    p.input = p.last = log_intensity(first.radiance[i]);
    p.reference = p.last + static_cast<float>(p.random.uniform(-static_cast<double>(p.on),
                                                               static_cast<double>(p.off)));
  }
}

double EventModel::noise_hz(const Pixel& p, float radiance) const noexcept {
  if (p.hot) return options_.hot_rate_hz;
  const double light = std::min(1.0, static_cast<double>(radiance));
  return options_.noise_rate_hz * (1.0 - 0.75 * light);
}

/// A low pass of first order, exact for an input that goes linearly from one exposure to the next,
/// so that its lag does not depend on how often is rendered.
float EventModel::filtered(Pixel& p, float radiance, double dt_s) const noexcept {
  const double corner_hz =
      options_.bandwidth_hz * std::min(1.0, static_cast<double>(radiance) + kLowestBandwidthShare);
  const double tau_s = 1.0 / (2.0 * std::numbers::pi * corner_hz);
  const auto from = static_cast<double>(p.input);
  p.input = log_intensity(radiance);
  const auto to = static_cast<double>(p.input);
  const double lag = (to - from) / dt_s * tau_s;
  const double off = static_cast<double>(p.last) - from + lag;
  return static_cast<float>(to - lag + off * std::exp(-dt_s / tau_s));
}

void EventModel::advance_row(int y, std::span<const Exposure> exposures, std::vector<Event>& out) {
  const std::size_t begin = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px_);
  for (int x = 0; x < width_px_; ++x) {
    const std::size_t i = begin + static_cast<std::size_t>(x);
    Pixel& p = pixels_[i];
    double t0_s = t_s_;
    for (const Exposure& e : exposures) {
      const double dt_s = e.t_s - t0_s;
      const float now = filtered(p, e.radiance[i], dt_s);
      const double noise = noise_hz(p, e.radiance[i]);
      p.reference -= p.on * static_cast<float>(options_.leak_rate_hz * dt_s);
      const bool quiet = now < p.reference + p.on && now > p.reference - p.off &&
                         p.noise_left > noise * dt_s && p.rests_until_s < 0.0;
      if (quiet) {
        p.noise_left -= noise * dt_s;
      } else {
        const double from = static_cast<double>(p.last);
        const double slope = (static_cast<double>(now) - from) / dt_s;
        Event event;
        event.x_px = static_cast<std::uint16_t>(x);
        event.y_px = static_cast<std::uint16_t>(y);
        advance_pixel(p, {t0_s, e.t_s, from, slope, noise}, event, out);
      }
      p.last = now;
      t0_s = e.t_s;
    }
  }
}

/// When the log intensity meets one of the two levels, from `t_s` on. It may be beyond one already:
/// the reference leaks.
EventModel::Crossing EventModel::next_crossing(const Pixel& p, const Piece& piece,
                                               double t_s) noexcept {
  const auto on_level = static_cast<double>(p.reference + p.on);
  const auto off_level = static_cast<double>(p.reference - p.off);
  const double here = piece.at(t_s);
  if (here >= on_level) return {t_s, true};
  if (here <= off_level) return {t_s, false};
  const bool rising = piece.slope > 0.0;
  if (piece.slope == 0.0) return {kNever, true};
  const double level = rising ? on_level : off_level;
  return {std::max(t_s, piece.t0_s + (level - piece.from) / piece.slope), rising};
}

void EventModel::advance_pixel(Pixel& p, const Piece& piece, Event event,
                               std::vector<Event>& out) const {
  double t_s = piece.t0_s;
  double noise_from_s = piece.t0_s;
  for (;;) {
    if (p.rests_until_s >= 0.0) {
      if (p.rests_until_s >= piece.t1_s) break;
      t_s = std::max(t_s, p.rests_until_s);
      p.reference = static_cast<float>(piece.at(t_s));
      p.rests_until_s = -1.0;
    }
    const Crossing crossing = next_crossing(p, piece, t_s);
    const double noise_s =
        piece.noise_hz > 0.0 ? std::max(t_s, noise_from_s + p.noise_left / piece.noise_hz) : kNever;
    const double fires_s = std::min(crossing.t_s, noise_s);
    if (!(fires_s <= piece.t1_s)) break;
    bool on = crossing.on;
    if (noise_s < crossing.t_s) {
      on = p.random.uniform() < 0.5;
      p.noise_left = p.random.exponential();
      noise_from_s = fires_s;
    }
    event.t = {Duration::from_s(fires_s).us};
    event.polarity = on ? Polarity::kOn : Polarity::kOff;
    out.push_back(event);
    p.rests_until_s = fires_s + options_.refractory_s;
    t_s = fires_s;
  }
  // What comes due while the pixel rests is lost, and waited for anew.
  p.noise_left -= (piece.t1_s - noise_from_s) * piece.noise_hz;
  if (p.noise_left <= 0.0) p.noise_left = p.random.exponential();
}

void sort_as_sent(std::vector<Event>& events) {
  // Stable: two events of a pixel within one microsecond keep their order.
  std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) {
    return std::tuple(a.t, a.y_px, a.x_px) < std::tuple(b.t, b.y_px, b.x_px);
  });
}

}  // namespace pled::sim
