#include "pled_vins/events/arc_star.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include <doctest/doctest.h>

#include "support/events/arc_star_reference.hpp"
#include "support/events/edge_stream.hpp"
#include "support/events/surface_fixture.hpp"

namespace pled {
namespace {

constexpr int kSize = 64;

/// Fires each pixel of a small sensor at most once, in order of its stamp. `stamp_us` below 0:
/// never.
template <typename StampOf>
void draw(ActiveSurface& surface, const StampOf& stamp_us) {
  std::vector<Event> events;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      if (const std::int64_t t = stamp_us(x, y); t >= 0)
        events.push_back(support::event_at(t, x, y));
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.t < b.t; });
  surface.insert(events);
}

/// Pixels of the newest wedge of a given opening at the centre; all others are older.
bool corner_of_wedge(double opening_rad) {
  support::OwnedSurface owned(kSize, kSize);
  draw(owned.surface, [&](int x, int y) -> std::int64_t {
    const double angle = std::atan2(y - 32, x - 32);
    const bool inside = std::abs(angle - 0.2) < 0.5 * opening_rad;
    return (inside ? 500'000 : 1'000) + 10 * std::abs(x - 32) + 10 * std::abs(y - 32);
  });
  return is_arc_star(owned.surface, 32, 32, Polarity::kOn);
}

}  // namespace

TEST_SUITE("events.arc_star") {
  TEST_CASE("it agrees with the definition on random surfaces, ties and silent pixels included") {
    std::size_t corners = 0;
    std::size_t tested = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
      std::mt19937_64 random(seed);
      // From smooth to rough, from all fired to few, from all different stamps to a handful.
      const std::uint64_t stamps = std::uint64_t{2} << (seed % 16);
      const std::uint64_t silent = seed % 4 == 0 ? 0 : seed % 4 == 1 ? 2 : seed % 4 == 2 ? 8 : 1;
      const bool smooth = seed % 3 == 0;
      const double slope_x = static_cast<double>(random() % 1000);
      const double slope_y = static_cast<double>(random() % 1000);
      support::OwnedSurface owned(kSize, kSize);
      draw(owned.surface, [&](int x, int y) -> std::int64_t {
        if (silent != 0 && random() % (2 * silent) == 0) return -1;
        const auto noise = static_cast<std::int64_t>(random() % stamps);
        const auto plane = static_cast<std::int64_t>(slope_x * (x % 20) + slope_y * (y % 23));
        return 1000 + (smooth ? plane + noise / 4 : noise);
      });
      for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
          const bool border = x < 4 || y < 4 || x >= kSize - 4 || y >= kSize - 4;
          const bool want =
              !border && support::arc_star_by_sets(owned.surface, x, y, Polarity::kOn);
          REQUIRE(is_arc_star(owned.surface, x, y, Polarity::kOn) == want);
          corners += want ? 1U : 0U;
          ++tested;
        }
      }
    }
    MESSAGE(corners << " corners in " << tested << " pixels");
    CHECK(corners > 1000);
    CHECK(corners < tested / 2);
  }

  TEST_CASE("a mirrored surface, where ties fall the other way, has the mirrored corners") {
    std::size_t corners = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      std::mt19937_64 random(seed);
      std::vector<std::int64_t> stamps_us(kSize * kSize);
      for (std::size_t i = 0; i < stamps_us.size(); ++i)  // slopes in coarse steps, and noise
        stamps_us[i] =
            static_cast<std::int64_t>((i % 20 * 3 + i / kSize % 23 * 2 + random() % seed) / 4);
      support::OwnedSurface plain(kSize, kSize);
      support::OwnedSurface mirrored(kSize, kSize);
      const auto stamp = [&](int x, int y) {
        return stamps_us[static_cast<std::size_t>(y * kSize + x)];
      };
      draw(plain.surface, stamp);
      draw(mirrored.surface, [&](int x, int y) { return stamp(kSize - 1 - x, y); });
      for (int y = 4; y < kSize - 4; ++y) {
        for (int x = 4; x < kSize - 4; ++x) {
          const bool corner = is_arc_star(plain.surface, x, y, Polarity::kOn);
          REQUIRE(is_arc_star(mirrored.surface, kSize - 1 - x, y, Polarity::kOn) == corner);
          corners += corner ? 1U : 0U;
        }
      }
    }
    CHECK(corners > 100);
  }

  TEST_CASE("it agrees with the definition when stamps have wrapped round") {
    support::OwnedSurface owned(kSize, kSize);
    std::mt19937_64 random(5);
    const std::int64_t wrap_us = std::int64_t{1} << 32;
    draw(owned.surface, [&](int, int) {
      return wrap_us - 100'000 + static_cast<std::int64_t>(random() % 200'000);
    });
    for (int y = 4; y < kSize - 4; ++y)
      for (int x = 4; x < kSize - 4; ++x)
        REQUIRE(is_arc_star(owned.surface, x, y, Polarity::kOn) ==
                support::arc_star_by_sets(owned.surface, x, y, Polarity::kOn));
  }

  TEST_CASE("a sharp wedge and its complement are corners; a straight edge is none") {
    const double pi = 3.141592653589793;
    CHECK(corner_of_wedge(pi / 2));
    CHECK(corner_of_wedge(3 * pi / 2));
    CHECK(!corner_of_wedge(pi));
    CHECK(!corner_of_wedge(2.1 * pi));
  }

  TEST_CASE("outside the border and on an empty surface there are no corners") {
    support::OwnedSurface owned(kSize, kSize);
    CHECK(!is_arc_star(owned.surface, 32, 32, Polarity::kOn));
    owned.surface.insert(support::busy_stream(1, 50'000, kSize, kSize, 0));
    for (int i = -5; i < kSize + 5; ++i) {
      CHECK(!is_arc_star(owned.surface, i, 3, Polarity::kOn));
      CHECK(!is_arc_star(owned.surface, kSize - 4, i, Polarity::kOn));
    }
  }
}

TEST_SUITE("events.arc_star_detector") {
  TEST_CASE("corners are those that a search without a grid would take, newest first") {
    support::EdgeStreamOptions options;
    options.events = 150'000;
    support::OwnedSurface owned(options.width_px, options.height_px);
    owned.surface.insert(support::edge_stream(options));
    const ActiveSurface& surface = owned.surface;
    const Timestamp t_ref = *surface.newest() + Duration{2000};
    std::mt19937_64 random(1);
    for (const double distance_px : {3.0, 10.0, 37.5}) {
      for (const std::size_t max_count : {std::size_t{12}, limits::kMaxPoints}) {
        EventConfig config;
        config.corner_min_distance_px = distance_px;
        std::vector<Eigen::Vector2f> occupied;
        for (int i = 0; i < 40; ++i)
          occupied.emplace_back(static_cast<float>(random() % 2400) / 10.0F,
                                static_cast<float>(random() % 1800) / 10.0F);
        occupied.push_back(occupied.front());  // two tracks may have met
        std::vector<EventCorner> want;
        const auto is_free = [&](float x, float y) {
          const auto far = [&](float ox, float oy) {
            return std::hypot(ox - x, oy - y) >= static_cast<float>(distance_px);
          };
          return std::all_of(occupied.begin(), occupied.end(),
                             [&](const auto& o) { return far(o.x(), o.y()); }) &&
                 std::all_of(want.begin(), want.end(), [&](const EventCorner& o) {
                   return far(static_cast<float>(o.x_px), static_cast<float>(o.y_px));
                 });
        };
        for (std::size_t i = 0; i < std::min<std::size_t>(surface.recent_size(), 4096); ++i) {
          const RecentEvent& e = surface.recent(i);
          const Timestamp t = surface.full_stamp(e.t_us);
          if (want.size() == max_count || t_ref - t > Duration::from_ms(30)) break;
          const auto p = static_cast<Polarity>(e.polarity());
          const auto other = p == Polarity::kOn ? Polarity::kOff : Polarity::kOn;
          if (surface.filtered(e.x_px(), e.y_px(), p) != t) continue;
          const std::optional<Timestamp> flipped = surface.filtered(e.x_px(), e.y_px(), other);
          if (flipped && *flipped > t) continue;
          if (!is_arc_star(surface, e.x_px(), e.y_px(), p)) continue;
          if (!is_free(static_cast<float>(e.x_px()), static_cast<float>(e.y_px()))) continue;
          want.push_back(
              {t, static_cast<std::int16_t>(e.x_px()), static_cast<std::int16_t>(e.y_px()), p});
        }
        FixedVector<EventCorner, limits::kMaxPoints> got;
        REQUIRE(got.push_back({}));  // must not stay
        const auto detector = std::make_unique<ArcStarDetector>(config);
        detector->detect(surface, t_ref, occupied, max_count, got);
        REQUIRE(got.size() == want.size());
        for (std::size_t i = 0; i < want.size(); ++i) {
          REQUIRE(got[i].t == want[i].t);
          REQUIRE(got[i].x_px == want[i].x_px);
          REQUIRE(got[i].y_px == want[i].y_px);
          REQUIRE(got[i].polarity == want[i].polarity);
        }
        if (distance_px < 20.0) CHECK(want.size() > 4);
      }
    }
  }

  TEST_CASE("old events are no candidates, and neither is anything on an empty surface") {
    support::OwnedSurface owned(240, 180);
    const auto detector = std::make_unique<ArcStarDetector>(EventConfig{});
    FixedVector<EventCorner, limits::kMaxPoints> out;
    detector->detect(owned.surface, {0}, {}, limits::kMaxPoints, out);
    CHECK(out.empty());
    support::EdgeStreamOptions options;
    options.events = 100'000;
    owned.surface.insert(support::edge_stream(options));
    detector->detect(owned.surface, *owned.surface.newest(), {}, limits::kMaxPoints, out);
    CHECK(!out.empty());
    detector->detect(owned.surface, *owned.surface.newest(), {}, 0, out);
    CHECK(out.empty());
    detector->detect(owned.surface, *owned.surface.newest() + Duration{30'001}, {},
                     limits::kMaxPoints, out);
    CHECK(out.empty());
  }

  TEST_CASE("occupied places that are not finite or off the sensor are passed over") {
    support::OwnedSurface owned(240, 180);
    support::EdgeStreamOptions options;
    options.events = 100'000;
    owned.surface.insert(support::edge_stream(options));
    const auto detector = std::make_unique<ArcStarDetector>(EventConfig{});
    FixedVector<EventCorner, limits::kMaxPoints> free;
    FixedVector<EventCorner, limits::kMaxPoints> got;
    detector->detect(owned.surface, *owned.surface.newest(), {}, limits::kMaxPoints, free);
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    const std::array<Eigen::Vector2f, 4> odd{Eigen::Vector2f(kNaN, 20), Eigen::Vector2f(20, kNaN),
                                             Eigen::Vector2f(-1e30F, 5), Eigen::Vector2f(5, 1e30F)};
    detector->detect(owned.surface, *owned.surface.newest(), odd, limits::kMaxPoints, got);
    CHECK(got.size() == free.size());
  }

  TEST_CASE("a large sensor and a small distance get a grid that fits its memory") {
    support::OwnedSurface owned(1280, 720);
    support::EdgeStreamOptions options;
    options.width_px = 1280;
    options.height_px = 720;
    options.events = 200'000;
    owned.surface.insert(support::edge_stream(options));
    EventConfig config;
    config.corner_min_distance_px = 3.0;
    const auto detector = std::make_unique<ArcStarDetector>(config);
    FixedVector<EventCorner, limits::kMaxPoints> out;
    detector->detect(owned.surface, *owned.surface.newest(), {}, limits::kMaxPoints, out);
    CHECK(out.size() > 20);
    for (std::size_t i = 0; i < out.size(); ++i)
      for (std::size_t k = 0; k < i; ++k)
        CHECK(std::hypot(out[i].x_px - out[k].x_px, out[i].y_px - out[k].y_px) >= 3.0);
  }
}

}  // namespace pled
