#include "pled_vins/events/time_surface.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

// e^{-6.24} < 1 / 510: half a grey level of 255.
constexpr double kHorizonInEta = 6.24;
constexpr std::uint64_t kMaxFreshness = 32767;

/// Whether the surface's 32-bit stamps tell ages at t: not so far from the newest event.
bool knows(const ActiveSurface& surface, Timestamp t) noexcept {
  const std::optional<Timestamp> newest = surface.newest();
  if (!newest) return false;
  const Duration apart = t - *newest;
  return apart.us > -ActiveSurface::kMaxJump_us && apart.us < ActiveSurface::kMaxJump_us;
}

std::uint8_t rounded(double grey) noexcept {
  return static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0, 255.0)));
}

}  // namespace

TimeSurface::TimeSurface(double eta_ms) noexcept {
  PLED_CHECK(eta_ms >= 1.0 && eta_ms <= 500.0);
  horizon_us_ = std::llround(kHorizonInEta * 1e3 * eta_ms);
  freshness_per_us_q32_ = (kMaxFreshness << 32) / static_cast<std::uint64_t>(horizon_us_);
  for (int k = 0; k < kSteps; ++k) {
    const double age_in_eta = kHorizonInEta * (kSteps - k - 0.5) / kSteps;  // a step's middle
    const double e = std::exp(-age_in_eta);
    const auto i = static_cast<std::size_t>(k);
    for (std::size_t p = 0; p < 2; ++p) {
      const double sign = p == 1 ? 1.0 : -1.0;
      grey_[static_cast<std::size_t>(SurfaceTone::kSigned)][p][i] =
          rounded(127.5 * (1.0 + sign * e));
      grey_[static_cast<std::size_t>(SurfaceTone::kUnsigned)][p][i] = rounded(255.0 * e);
    }
  }
}

std::uint16_t TimeSurface::key(const SurfacePixel& pixel, std::uint32_t t_ref_us,
                               std::int64_t& age_us) const noexcept {
  if (t_ref_us - pixel.last_us >= static_cast<std::uint32_t>(horizon_us_) &&
      static_cast<std::int32_t>(t_ref_us - pixel.last_us) >= 0)
    return 0;  // most pixels: filtered stamps are never newer than this one
  const auto age_of = [&](std::size_t p) {
    if (!pixel.fired(p)) return horizon_us_;
    return std::int64_t{static_cast<std::int32_t>(t_ref_us - pixel.filtered_us[p])};
  };
  const std::int64_t off = age_of(0);
  const std::int64_t on = age_of(1);
  age_us = std::min(off, on);
  if (age_us >= horizon_us_) return 0;
  const auto left_us =
      static_cast<std::uint64_t>(horizon_us_ - 1 - std::max<std::int64_t>(age_us, 0));
  const std::uint64_t freshness = 1 + (left_us * freshness_per_us_q32_ >> 32);
  return static_cast<std::uint16_t>(2 * freshness + (on <= off ? 1U : 0U));
}

void TimeSurface::carry_all(const ActiveSurface& surface, const EventWarp& warp,
                            const TurnSlices& slices,
                            std::span<std::uint16_t> keys) const noexcept {
  const std::span<const SurfacePixel> pixels = surface.pixels();
  const auto t_ref_us = static_cast<std::uint32_t>(slices.t_ref.us);
  const auto width = static_cast<std::size_t>(warp.width_px());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    std::int64_t age_us = 0;
    const std::uint16_t mine = key(pixels[i], t_ref_us, age_us);
    if (mine == 0) continue;
    const std::size_t slice = slices.index(slices.t_ref.us - age_us);
    if (slice == slices.count) continue;
    const WarpedPixel at = warp.warp_pixel(i, slices, slice);
    if (at == kOutsideGrid) continue;
    std::uint16_t& there =
        keys[static_cast<std::size_t>(at.y_px) * width + static_cast<std::size_t>(at.x_px)];
    there = std::max(there, mine);
  }
}

void TimeSurface::fill_row(const std::uint16_t* keys, std::size_t width, SurfaceTone tone,
                           std::span<std::uint8_t> out) const noexcept {
  const auto newer_of_both = [](std::uint16_t a, std::uint16_t b) {
    return a == 0 || b == 0 ? std::uint16_t{0} : std::max(a, b);
  };
  const std::uint16_t* above = keys - width;
  const std::uint16_t* below = keys + width;
  for (std::size_t x = 1; x + 1 < width; ++x) {
    if (keys[x] != 0) continue;
    const std::uint16_t filled =
        std::max(newer_of_both(keys[x - 1], keys[x + 1]), newer_of_both(above[x], below[x]));
    if (filled != 0) out[x] = grey(tone, filled);
  }
}

void TimeSurface::paint(std::span<const std::uint16_t> keys, SurfaceTone tone,
                        std::span<std::uint8_t> out) const noexcept {
  for (std::size_t i = 0; i < keys.size(); ++i) out[i] = grey(tone, keys[i]);
}

bool TimeSurface::render(const ActiveSurface& surface, Timestamp t_ref, SurfaceTone tone,
                         ImageView<std::uint8_t> out) const noexcept {
  if (out.empty() || out.width != surface.width_px() || out.height != surface.height_px())
    return false;
  const bool known = knows(surface, t_ref);
  const auto t_ref_us = static_cast<std::uint32_t>(t_ref.us);
  const SurfacePixel* pixel = surface.pixels().data();
  for (int y = 0; y < out.height; ++y) {
    std::uint8_t* row = out.row(y);
    for (int x = 0; x < out.width; ++x, ++pixel) {
      std::int64_t age_us = 0;
      row[x] = grey(tone, known ? key(*pixel, t_ref_us, age_us) : std::uint16_t{0});
    }
  }
  return true;
}

bool TimeSurface::render(const ActiveSurface& surface, const EventWarp& warp,
                         const TurnSlices& slices, SurfaceTone tone, HoleFill fill,
                         std::span<std::uint16_t> scratch,
                         ImageView<std::uint8_t> out) const noexcept {
  if (out.empty() || out.width != warp.width_px() || out.height != warp.height_px()) return false;
  if (surface.width_px() != warp.sensor_width_px() ||
      surface.height_px() != warp.sensor_height_px())
    return false;
  const std::size_t size =
      static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height);
  if (scratch.size() < size) return false;
  scratch = scratch.first(size);
  std::fill(scratch.begin(), scratch.end(), std::uint16_t{0});
  if (knows(surface, slices.t_ref)) carry_all(surface, warp, slices, scratch);
  const auto width = static_cast<std::size_t>(out.width);
  for (int y = 0; y < out.height; ++y) {
    const std::size_t begin = static_cast<std::size_t>(y) * width;
    const std::span<const std::uint16_t> keys = scratch.subspan(begin, width);
    const std::span<std::uint8_t> row(out.row(y), width);
    paint(keys, tone, row);
    if (fill == HoleFill::kBetween && y > 0 && y + 1 < out.height)
      fill_row(scratch.data() + begin, width, tone, row);
  }
  return true;
}
}  // namespace pled
