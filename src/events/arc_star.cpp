#include "pled_vins/events/arc_star.hpp"

#include <algorithm>
#include <cmath>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

struct Offset {
  int dx;
  int dy;
};

/// A circle and the sizes of the newest arc that make a corner: short ones, and the complement of
/// short ones.
template <std::size_t N>
struct Circle {
  std::array<Offset, N> offsets;
  int shortest;
  int longest;

  [[nodiscard]] constexpr bool is_corner(int arc) const noexcept {
    constexpr int kAround = static_cast<int>(N);
    return arc <= longest || (arc >= kAround - longest && arc <= kAround - shortest);
  }
};

constexpr Circle<16> kSmall{{{{0, 3},
                              {1, 3},
                              {2, 2},
                              {3, 1},
                              {3, 0},
                              {3, -1},
                              {2, -2},
                              {1, -3},
                              {0, -3},
                              {-1, -3},
                              {-2, -2},
                              {-3, -1},
                              {-3, 0},
                              {-3, 1},
                              {-2, 2},
                              {-1, 3}}},
                            3,
                            6};
constexpr Circle<20> kLarge{{{{0, 4},   {1, 4},  {2, 3},  {3, 2},  {4, 1},   {4, 0},   {4, -1},
                              {3, -2},  {2, -3}, {1, -4}, {0, -4}, {-1, -4}, {-2, -3}, {-3, -2},
                              {-4, -1}, {-4, 0}, {-4, 1}, {-3, 2}, {-2, 3},  {-1, 4}}},
                            4,
                            8};

/// Size of the newest arc on a circle around the pixel, see is_arc_star().
template <std::size_t N>
int newest_arc(const Circle<N>& circle, const SurfacePixel* centre, std::ptrdiff_t stride,
               std::size_t polarity, std::uint32_t oldest_us) noexcept {
  // Newness of the pixels, 0 for those that never fired; twice round, so that no step wraps.
  std::array<std::uint32_t, 2 * N> newness;
  std::size_t start = 0;
  for (std::size_t i = 0; i < N; ++i) {
    const SurfacePixel& pixel = centre[circle.offsets[i].dy * stride + circle.offsets[i].dx];
    newness[i] = pixel.fired(polarity) ? pixel.filtered_us[polarity] - oldest_us : 0;
    newness[i + N] = newness[i];
    if (newness[i] > newness[start]) start = i;
  }
  // All that has been visited is one arc. When its newest end is not older than the segment, what
  // was skipped on the way is older than neither side's next pixel, so the segment is then all of
  // it.
  std::size_t up = start + 1;
  std::size_t down = start + N - 1;
  std::uint32_t oldest_seen = newness[start];
  std::uint32_t segment_oldest = oldest_seen;
  int arc = circle.shortest;
  for (int visited = 2; visited <= static_cast<int>(N); ++visited) {
    const bool goes_up = newness[up] > newness[down];
    const std::uint32_t next = goes_up ? newness[up] : newness[down];
    up += goes_up ? 1U : 0U;
    down -= goes_up ? 0U : 1U;
    oldest_seen = std::min(oldest_seen, next);
    const bool joins = visited <= circle.shortest || next >= segment_oldest;
    segment_oldest = joins ? oldest_seen : segment_oldest;
    arc = joins ? std::max(visited, circle.shortest) : arc;
  }
  return arc;
}

bool is_corner(const ActiveSurface& surface, int x, int y, std::size_t polarity) noexcept {
  const std::ptrdiff_t stride = surface.width_px();
  const SurfacePixel* centre = surface.pixels().data() + y * stride + x;
  // Half the range below the newest stamp: the sweep keeps all others above that.
  const std::uint32_t oldest_us = static_cast<std::uint32_t>(surface.newest()->us) - 0x7FFF'FFFFU;
  return kSmall.is_corner(newest_arc(kSmall, centre, stride, polarity, oldest_us)) &&
         kLarge.is_corner(newest_arc(kLarge, centre, stride, polarity, oldest_us));
}

bool inside_border(const ActiveSurface& surface, int x, int y) noexcept {
  return x >= kArcStarBorderPx && y >= kArcStarBorderPx &&
         x < surface.width_px() - kArcStarBorderPx && y < surface.height_px() - kArcStarBorderPx;
}

}  // namespace

bool is_arc_star(const ActiveSurface& surface, int x_px, int y_px, Polarity polarity) noexcept {
  if (!surface.newest() || !inside_border(surface, x_px, y_px)) return false;
  return is_corner(surface, x_px, y_px, static_cast<std::size_t>(polarity));
}

ArcStarDetector::ArcStarDetector(const EventConfig& config) noexcept
    : min_distance_px_(static_cast<float>(config.corner_min_distance_px)),
      max_age_us_(static_cast<std::uint32_t>(std::lround(1e3 * config.corner_max_age_ms))),
      max_candidates_(static_cast<std::size_t>(config.corner_max_candidates)) {
  PLED_CHECK(check(config).key == nullptr);
}

void ArcStarDetector::detect(const ActiveSurface& surface, Timestamp t_ref,
                             std::span<const Eigen::Vector2f> occupied, std::size_t max_count,
                             FixedVector<EventCorner, limits::kMaxPoints>& out) noexcept {
  out.clear();
  lay_grid(surface.width_px(), surface.height_px());
  PLED_CHECK(occupied.size() <= limits::kMaxPoints);
  for (const Eigen::Vector2f& place : occupied) occupy(place.x(), place.y());
  max_count = std::min(max_count, out.capacity());
  const std::size_t candidates = std::min(surface.recent_size(), max_candidates_);
  for (std::size_t i = 0; i < candidates && out.size() < max_count; ++i) {
    const RecentEvent& e = surface.recent(i);
    const Timestamp t = surface.full_stamp(e.t_us);
    if (t_ref - t > Duration{max_age_us_}) return;  // and so are all that follow
    const int x = e.x_px();
    const int y = e.y_px();
    const std::size_t p = e.polarity();
    if (!inside_border(surface, x, y)) continue;
    const SurfacePixel& pixel = surface.at(y, x);
    // Fired again since, or in the other polarity: the picture shows something else there.
    if (pixel.filtered_us[p] != e.t_us || (pixel.state >> p & 1U) == 0) continue;
    if (!is_free(static_cast<float>(x), static_cast<float>(y))) continue;
    if (!is_corner(surface, x, y, p)) continue;
    occupy(static_cast<float>(x), static_cast<float>(y));
    const bool pushed = out.push_back(
        {t, static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), static_cast<Polarity>(p)});
    PLED_CHECK(pushed);
  }
}

void ArcStarDetector::lay_grid(int width_px, int height_px) noexcept {
  // A cell of min_distance / sqrt(2) holds one corner; with a larger one, or with places that are
  // closer together, it holds a list. Two cells are at least the distance either way.
  cell_px_ = min_distance_px_ * 0.7071F;
  const auto cells = [&](int side_px) {
    return static_cast<int>(static_cast<float>(side_px) / cell_px_) + 1;
  };
  while (static_cast<std::size_t>(cells(width_px)) * static_cast<std::size_t>(cells(height_px)) >
         limits::kMaxEventCells)
    cell_px_ *= 1.25F;
  columns_ = cells(width_px);
  rows_ = cells(height_px);
  std::fill_n(cells_.begin(), static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_),
              std::uint16_t{0});
  places_.clear();
}

int ArcStarDetector::cell_of(float px) const noexcept { return static_cast<int>(px / cell_px_); }

void ArcStarDetector::occupy(float x_px, float y_px) noexcept {
  const float width_px = static_cast<float>(columns_) * cell_px_;
  const float height_px = static_cast<float>(rows_) * cell_px_;
  if (!(x_px >= 0.0F && y_px >= 0.0F && x_px < width_px && y_px < height_px)) return;
  const int column = std::min(cell_of(x_px), columns_ - 1);
  const int row = std::min(cell_of(y_px), rows_ - 1);
  std::uint16_t& first = cells_[static_cast<std::size_t>(row * columns_ + column)];
  const bool pushed = places_.push_back({x_px, y_px, first});
  PLED_CHECK(pushed);
  first = static_cast<std::uint16_t>(places_.size());
}

bool ArcStarDetector::is_free(float x_px, float y_px) const noexcept {
  const int column = cell_of(x_px);
  const int row = cell_of(y_px);
  for (int r = std::max(row - 2, 0); r <= std::min(row + 2, rows_ - 1); ++r) {
    for (int c = std::max(column - 2, 0); c <= std::min(column + 2, columns_ - 1); ++c) {
      for (std::uint16_t k = cells_[static_cast<std::size_t>(r * columns_ + c)]; k != 0;
           k = places_[k - 1U].next) {
        const float dx = places_[k - 1U].x_px - x_px;
        const float dy = places_[k - 1U].y_px - y_px;
        if (dx * dx + dy * dy < min_distance_px_ * min_distance_px_) return false;
      }
    }
  }
  return true;
}

}  // namespace pled
