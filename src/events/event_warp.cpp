#include "pled_vins/events/event_warp.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "pled_vins/core/check.hpp"
#include "src/events/lanes.hpp"

namespace pled {
namespace {

using lanes::Doubles;
using lanes::Floats;
using lanes::Ints;

constexpr int kMaxSide_px = 16384;
constexpr int kMaxPixels = 1 << 24;
constexpr auto kOutsideBits = std::bit_cast<std::int32_t>(kOutsideGrid);

/// x and y of four events, in the two halves of each lane.
inline Ints pixels_of(const Event* events) noexcept {
  // The second 8 bytes of an event are x, y, polarity and padding.
  static_assert(offsetof(Event, x_px) == 8 && offsetof(Event, y_px) == 10);
  const auto load = [&](std::size_t i) {
    Ints bytes;
    std::memcpy(&bytes, events + i, sizeof(bytes));
    return bytes;
  };
  const Ints low = lanes::shuffle<2, 6, 3, 7>(load(0), load(1));
  const Ints high = lanes::shuffle<2, 6, 3, 7>(load(2), load(3));
  return lanes::shuffle<0, 1, 4, 5>(low, high);
}

double corner_radius_squared(const CameraCalibration& grid) noexcept {
  const double x = std::max(grid.cx_px, grid.width_px - 1 - grid.cx_px) / grid.fx_px;
  const double y = std::max(grid.cy_px, grid.height_px - 1 - grid.cy_px) / grid.fy_px;
  return x * x + y * y;
}

struct Sensor {
  const float* bearings_xy;
  int width, height;

  /// x and y of the bearing at a pixel, as they lie in memory.
  [[nodiscard]] double bearing(std::uint32_t index) const noexcept {
    double pair = 0.0;
    std::memcpy(&pair, bearings_xy + 2 * static_cast<std::size_t>(index), sizeof(pair));
    return pair;
  }
};

/// Raw pixels, x and y in the halves of each lane, to pixels of the grid, packed alike.
inline Ints warp_four(const Ints& raw, const Sensor& sensor, const std::array<float, 9>& R,
                      const PinholeGrid& grid) noexcept {
  const Ints x = raw & 0xFFFF;
  const Ints y = lanes::as<Ints>(lanes::as<lanes::Unsigneds>(raw) >> 16U);
  const Ints on_sensor = (x < sensor.width) & (y < sensor.height);
  // Exact: build() sees to it that a sensor has at most 2^24 pixels.
  const Floats place = __builtin_convertvector(y, Floats) * static_cast<float>(sensor.width) +
                       __builtin_convertvector(x, Floats);
  const auto index = lanes::as<lanes::Unsigneds>(__builtin_convertvector(place, Ints) & on_sensor);
  const Floats low = lanes::as<Floats>(Doubles{sensor.bearing(index[0]), sensor.bearing(index[1])});
  const Floats high =
      lanes::as<Floats>(Doubles{sensor.bearing(index[2]), sensor.bearing(index[3])});
  const PinholeGrid::Point<Floats> at = grid.project<Floats>(
      lanes::shuffle<0, 2, 4, 6>(low, high), lanes::shuffle<1, 3, 5, 7>(low, high), R);
  const Ints inside = on_sensor & (at.z > 0.0F) & (at.u >= 0.0F) & (at.u < grid.width_px) &
                      (at.v >= 0.0F) & (at.v < grid.height_px);
  const auto truncated = [&](const Floats& value) {
    return __builtin_convertvector(lanes::as<Floats>(lanes::as<Ints>(value) & inside), Ints);
  };
  return truncated(at.u) | truncated(at.v) << 16 | (kOutsideBits & ~inside);
}

}  // namespace

CameraCalibration rectified(const CameraCalibration& camera, int margin_px) noexcept {
  CameraCalibration grid = camera;
  grid.width_px += 2 * margin_px;
  grid.height_px += 2 * margin_px;
  grid.cx_px += margin_px;
  grid.cy_px += margin_px;
  grid.distortion = Distortion::kNone;
  grid.coeffs = {};
  return grid;
}

bool EventWarp::build(const UndistortionTable& table, const CameraCalibration& grid) noexcept {
  const auto fits = [](int width, int height) {
    return width >= 1 && height >= 1 && width <= kMaxSide_px && height <= kMaxSide_px &&
           width * height <= kMaxPixels;
  };
  if (!fits(table.width_px(), table.height_px()) || !fits(grid.width_px, grid.height_px))
    return false;
  if (grid.distortion != Distortion::kNone || !(grid.fx_px > 0.0) || !(grid.fy_px > 0.0))
    return false;
  table_ = table;
  bearings_xy_ = table.bearings_xy().data();
  sensor_width_px_ = table.width_px();
  sensor_height_px_ = table.height_px();
  width_px_ = grid.width_px;
  height_px_ = grid.height_px;
  grid_ = {static_cast<float>(grid.fx_px),       static_cast<float>(grid.fy_px),
           static_cast<float>(grid.cx_px + 0.5), static_cast<float>(grid.cy_px + 0.5),
           static_cast<float>(grid.width_px),    static_cast<float>(grid.height_px)};
  // A turn by one radian moves a point by f (1 + r^2) at most.
  const double stretch = 1.0 + std::min(corner_radius_squared(grid), 1.0);
  slice_error_rad_ = kMaxSliceError_px / (mean_focal_px(grid) * stretch);
  return true;
}

void EventWarp::warp(std::span<const Event> events, const TurnSlices& slices,
                     std::span<WarpedPixel> out) const noexcept {
  PLED_CHECK(out.size() >= events.size());
  std::size_t i = 0;
  while (i < events.size()) {
    const std::size_t slice = slices.index(events[i].t.us);
    std::size_t end = i + 1;
    if (slice == slices.count) {
      out[i] = kOutsideGrid;
      i = end;
      continue;
    }
    // Ends are seen one event in a few hundred; until then one comparison for each will do.
    const std::int64_t begin_us = slices.begin_of_us(slice);
    const std::uint64_t length_us = std::uint64_t{1} << slices.length_log2_us;
    const auto inside = [&](const Event& e) {
      return static_cast<std::uint64_t>(e.t.us) - static_cast<std::uint64_t>(begin_us) < length_us;
    };
    while (end + 8 <= events.size() && inside(events[end + 7])) end += 8;
    while (end < events.size() && inside(events[end])) ++end;
    warp_slice(events.subspan(i, end - i), slices.R_ref_slice[slice], out.subspan(i, end - i));
    i = end;
  }
}

void EventWarp::warp_slice(std::span<const Event> events, const std::array<float, 9>& R,
                           std::span<WarpedPixel> out) const noexcept {
  // Copies, which no store through `out` can change.
  const std::array<float, 9> turn = R;
  const Sensor sensor{bearings_xy_, sensor_width_px_, sensor_height_px_};
  const PinholeGrid grid = grid_;
  const std::size_t fours = events.size() / 4 * 4;
  std::size_t i = 0;
  for (; i < fours; i += 4) {
    const Ints warped = warp_four(pixels_of(events.data() + i), sensor, turn, grid);
    std::memcpy(static_cast<void*>(out.data() + i), &warped, sizeof(warped));
  }
  if (i == events.size()) return;
  std::array<Event, 4> rest{};
  std::copy(events.begin() + static_cast<std::ptrdiff_t>(i), events.end(), rest.begin());
  const Ints warped = warp_four(pixels_of(rest.data()), sensor, turn, grid);
  std::memcpy(static_cast<void*>(out.data() + i), &warped,
              (events.size() - i) * sizeof(WarpedPixel));
}

std::optional<Eigen::Vector2f> EventWarp::carry(const Eigen::Vector2f& raw_px, Timestamp t,
                                                const TurnSlices& slices) const noexcept {
  const std::size_t slice = slices.index(t.us);
  if (slice == slices.count) return std::nullopt;
  const std::optional<Eigen::Vector2f> bearing = table_.lookup(raw_px.x(), raw_px.y());
  if (!bearing) return std::nullopt;
  return carry_bearing(bearing->x(), bearing->y(), slices.R_ref_slice[slice]);
}

}  // namespace pled
