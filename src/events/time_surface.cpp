#include "pled_vins/events/time_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "pled_vins/core/check.hpp"
#include "src/events/lanes.hpp"

namespace pled {
namespace {

// e^{-6.24} < 1 / 510: half a grey level of 255.
constexpr double kHorizonInEta = 6.24;
// Ours: e^{-4} is 2 grey levels. Older events smear what is newer more than they add to it: tracks
// last longest with 3 to 4 eta.
constexpr double kBlendedInEta = 4.0;
/// Sums of one pixel of the grid, a register full.
constexpr std::ptrdiff_t kCellFloats = 4;

using lanes::Floats;

/// Whether the surface's 32-bit stamps tell ages at t: not so far from the newest event.
bool knows(const ActiveSurface& surface, Timestamp t) noexcept {
  const std::optional<Timestamp> newest = surface.newest();
  if (!newest) return false;
  const Duration apart = t - *newest;
  return apart.us > -ActiveSurface::kMaxJump_us && apart.us < ActiveSurface::kMaxJump_us;
}

/// Whether a pixel's events are all at least so old: accepted ones are never newer than the last.
bool has_faded(const SurfacePixel& pixel, std::uint32_t t_ref_us, std::int32_t age_us) noexcept {
  return static_cast<std::int32_t>(t_ref_us - pixel.last_us) >= age_us;
}

std::uint8_t neutral(SurfaceTone tone) noexcept { return tone == SurfaceTone::kSigned ? 128 : 0; }

std::uint8_t rounded(double grey) noexcept {
  return static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0, 255.0)));
}

void clear(ImageView<std::uint8_t> out, SurfaceTone tone) noexcept {
  for (int y = 0; y < out.height; ++y) std::fill_n(out.row(y), out.width, neutral(tone));
}

}  // namespace

TimeSurface::TimeSurface(double eta_ms) noexcept {
  PLED_CHECK(eta_ms >= 1.0 && eta_ms <= 500.0);
  horizon_us_ = static_cast<std::int32_t>(std::lround(kHorizonInEta * 1e3 * eta_ms));
  blended_us_ = static_cast<std::int32_t>(std::lround(kBlendedInEta * 1e3 * eta_ms));
  steps_per_us_q32_ = (std::uint64_t{kSteps} << 32) / static_cast<std::uint64_t>(horizon_us_);
  for (std::size_t k = 0; k < kSteps; ++k) {
    const double middle = (static_cast<double>(k) + 0.5) / kSteps;
    const double e = std::exp(-kHorizonInEta * middle);
    decay_[k] = static_cast<float>(e);
    for (std::size_t p = 0; p < 2; ++p) {
      const double sign = p == 1 ? 1.0 : -1.0;
      grey_[static_cast<std::size_t>(SurfaceTone::kSigned)][p][k] =
          rounded(127.5 * (1.0 + sign * e));
      grey_[static_cast<std::size_t>(SurfaceTone::kUnsigned)][p][k] = rounded(255.0 * e);
    }
  }
}

std::int32_t TimeSurface::age_us(const SurfacePixel& pixel, std::size_t polarity,
                                 std::uint32_t t_ref_us) const noexcept {
  if (!pixel.fired(polarity)) return horizon_us_;
  const auto age_us = static_cast<std::int32_t>(t_ref_us - pixel.filtered_us[polarity]);
  return std::clamp(age_us, 0, horizon_us_);
}

bool TimeSurface::render(const ActiveSurface& surface, Timestamp t_ref, SurfaceTone tone,
                         ImageView<std::uint8_t> out) const noexcept {
  if (out.empty() || out.width != surface.width_px() || out.height != surface.height_px())
    return false;
  clear(out, tone);
  if (!knows(surface, t_ref)) return true;
  const auto& grey = grey_[static_cast<std::size_t>(tone)];
  const auto t_ref_us = static_cast<std::uint32_t>(t_ref.us);
  const SurfacePixel* pixel = surface.pixels().data();
  for (int y = 0; y < out.height; ++y) {
    std::uint8_t* row = out.row(y);
    for (int x = 0; x < out.width; ++x, ++pixel) {
      if (has_faded(*pixel, t_ref_us, horizon_us_)) continue;
      const std::int32_t off_us = age_us(*pixel, 0, t_ref_us);
      const std::int32_t on_us = age_us(*pixel, 1, t_ref_us);
      const std::int32_t newest_us = std::min(off_us, on_us);
      if (newest_us < horizon_us_) row[x] = grey[on_us <= off_us ? 1 : 0][step(newest_us)];
    }
  }
  return true;
}

bool TimeSurface::render(const ActiveSurface& surface, const EventWarp& warp,
                         const TurnSlices& slices, SurfaceTone tone, Meeting meeting,
                         std::span<float> scratch, ImageView<std::uint8_t> out) const noexcept {
  if (out.empty() || out.width != warp.width_px() || out.height != warp.height_px()) return false;
  if (surface.width_px() != warp.sensor_width_px()) return false;
  if (surface.height_px() != warp.sensor_height_px()) return false;
  const std::size_t floats = floats_needed(out.width, out.height);
  if (scratch.size() < floats) return false;
  clear(out, tone);
  if (!knows(surface, slices.t_ref)) return true;
  if (meeting == Meeting::kNewest)
    draw_newest(surface, warp, slices, tone, scratch.first(floats / kCellFloats), out);
  else
    draw_blended(surface, warp, slices, tone, scratch.first(floats), out);
  return true;
}

template <typename Place>
void TimeSurface::carry_all(const ActiveSurface& surface, const EventWarp& warp,
                            const TurnSlices& slices, std::int32_t reach_us,
                            const Place& place) const noexcept {
  const std::span<const SurfacePixel> pixels = surface.pixels();
  const auto t_ref_us = static_cast<std::uint32_t>(slices.t_ref.us);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (has_faded(pixels[i], t_ref_us, reach_us)) continue;
    for (std::size_t p = 0; p < 2; ++p) {
      const std::int32_t age = age_us(pixels[i], p, t_ref_us);
      if (age >= reach_us) continue;
      const std::size_t slice = slices.index(slices.t_ref.us - age);
      if (slice == slices.count) continue;
      const std::optional<Eigen::Vector2f> at = warp.carry_pixel(i, slices, slice);
      if (at) place(at->x(), at->y(), age, p);
    }
  }
}

void TimeSurface::draw_newest(const ActiveSurface& surface, const EventWarp& warp,
                              const TurnSlices& slices, SurfaceTone tone, std::span<float> left_us,
                              ImageView<std::uint8_t> out) const noexcept {
  // Time that is left to each pixel, below 0 for OFF; microseconds are exact in float.
  std::fill(left_us.begin(), left_us.end(), 0.0F);
  const auto& grey = grey_[static_cast<std::size_t>(tone)];
  carry_all(surface, warp, slices, horizon_us_,
            [&](float x_px, float y_px, std::int32_t age, std::size_t p) {
              const int x = static_cast<int>(x_px + 0.5F);
              const int y = static_cast<int>(y_px + 0.5F);
              const auto left = static_cast<float>(horizon_us_ - age);
              float& there =
                  left_us[static_cast<std::size_t>(y) * static_cast<std::size_t>(out.width) +
                          static_cast<std::size_t>(x)];
              if (left < std::abs(there) || (left == std::abs(there) && p == 0)) return;
              there = p == 1 ? left : -left;
              out.at(y, x) = grey[p][step(age)];
            });
}

void TimeSurface::draw_blended(const ActiveSurface& surface, const EventWarp& warp,
                               const TurnSlices& slices, SurfaceTone tone, std::span<float> sums,
                               ImageView<std::uint8_t> out) const noexcept {
  std::fill(sums.begin(), sums.end(), 0.0F);
  const auto width = static_cast<std::ptrdiff_t>(out.width);
  carry_all(surface, warp, slices, blended_us_,
            [&](float x_px, float y_px, std::int32_t age, std::size_t p) {
              const float e = decay_[step(age)];
              const float value = p == 1 || tone == SurfaceTone::kUnsigned ? e : -e;
              // To be summed up with weight w: w, w e, w e (p e).
              const Floats event{1.0F, e, e * value, 0.0F};
              // x and y are above -1, where truncation after adding 1 is the floor.
              const int x = static_cast<int>(x_px + 1.0F) - 1;
              const int y = static_cast<int>(y_px + 1.0F) - 1;
              const float right = x_px - static_cast<float>(x);
              const float below = y_px - static_cast<float>(y);
              const bool inner = x >= 0 && y >= 0 && x + 1 < out.width && y + 1 < out.height;
              const auto share = [&](int to_x, int to_y, float w) {
                if (!inner && (to_x < 0 || to_y < 0 || to_x >= out.width || to_y >= out.height))
                  return;
                float* const cell = sums.data() + kCellFloats * (to_y * width + to_x);
                const Floats sum = lanes::load(cell) + w * event;
                std::memcpy(cell, &sum, sizeof(sum));
              };
              const float beside = 1.0F - right;
              const float above = 1.0F - below;
              share(x, y, beside * above);
              share(x + 1, y, right * above);
              share(x, y + 1, beside * below);
              share(x + 1, y + 1, right * below);
            });
  const float scale = tone == SurfaceTone::kSigned ? 127.5F : 255.0F;
  const float middle = tone == SurfaceTone::kSigned ? 128.0F : 0.5F;  // truncation then rounds
  const float* cell = sums.data();
  for (int y = 0; y < out.height; ++y) {
    std::uint8_t* const row = out.row(y);
    for (int x = 0; x < out.width; ++x, cell += kCellFloats) {
      if (!(cell[1] > 0.0F)) continue;  // no event has come
      const float mean = cell[2] / cell[1] * std::min(cell[0], 1.0F);
      row[x] = static_cast<std::uint8_t>(static_cast<std::int32_t>(middle + scale * mean));
    }
  }
}

}  // namespace pled
