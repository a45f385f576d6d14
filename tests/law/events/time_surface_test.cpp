#include "pled_vins/events/time_surface.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include <doctest/doctest.h>

#include "support/events/edge_stream.hpp"
#include "support/events/surface_fixture.hpp"
#include "support/events/turning_camera.hpp"

namespace pled {
namespace {

struct Picture {
  Picture(int width_px, int height_px)
      : width(width_px),
        height(height_px),
        grey(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 77),
        scratch(grey.size(), 0xAAAA) {}
  [[nodiscard]] ImageView<std::uint8_t> view() { return {grey.data(), width, height, width}; }
  [[nodiscard]] int at(int y, int x) const { return grey[static_cast<std::size_t>(y * width + x)]; }

  int width;
  int height;
  std::vector<std::uint8_t> grey;
  std::vector<std::uint16_t> scratch;
};

/// Half a step of the table is 0.8 grey levels where the picture is brightest, and rounding 0.5.
constexpr double kWithin = 1.3;

double formula(SurfaceTone tone, std::optional<double> age_us, bool on, double eta_ms) {
  const double e = age_us ? std::exp(-std::max(*age_us, 0.0) / (1e3 * eta_ms)) : 0.0;
  if (tone == SurfaceTone::kUnsigned) return 255.0 * e;
  return 127.5 * (1.0 + (on ? e : -e));
}

CameraCalibration pinhole() {
  CameraCalibration c;
  c.width_px = 120;
  c.height_px = 90;
  c.fx_px = c.fy_px = 100.0;
  c.cx_px = 59.5;
  c.cy_px = 44.5;
  return c;
}

/// A surface of moving edges seen by a turning camera, and everything that carries it.
struct Scene {
  explicit Scene(double eta_ms = 20.0)
      : surface(120, 90),
        bearings(UndistortionTable::floats_needed(120, 90)),
        time_surface(eta_ms) {
    support::EdgeStreamOptions options;
    options.width_px = 120;
    options.height_px = 90;
    options.events = 60'000;
    options.rate_hz = 2e5;
    options.begin_us = 0;
    events = support::edge_stream(options);
    surface.surface.insert(events);
    REQUIRE(table.build(Camera(pinhole()), bearings));
    REQUIRE(warp.build(table, rectified(pinhole())));
    const support::TurningBody body{0.8, 0.05, 2.0};
    turn.extend(body.samples(0, 310'000, 1000), Eigen::Vector3d::Zero(),
                Eigen::Quaterniond::Identity());
    const Timestamp from = std::max(t_ref - time_surface.horizon(), *turn.oldest());
    REQUIRE(turn.slices(t_ref, from, t_ref, warp.slice_error_rad(), slices));
  }

  support::OwnedSurface surface;
  std::vector<Event> events;
  std::vector<float> bearings;
  UndistortionTable table;
  EventWarp warp;
  TurnHistory turn;
  TurnSlices slices;
  TimeSurface time_surface;
  Timestamp t_ref{300'000};
};

/// The key of a pixel by its definition: the newest accepted event of either polarity.
struct Newest {
  std::optional<std::int64_t> t_us;
  bool on = false;
};

Newest newest_of(const ActiveSurface& surface, int x, int y) {
  const std::optional<Timestamp> off = surface.filtered(x, y, Polarity::kOff);
  const std::optional<Timestamp> on = surface.filtered(x, y, Polarity::kOn);
  if (!off && !on) return {};
  const bool is_on = on && (!off || *on >= *off);
  return {is_on ? on->us : off->us, is_on};
}

}  // namespace

TEST_SUITE("events.time_surface") {
  TEST_CASE("every age has the grey value of the formula, within 1.3 levels") {
    for (const double eta_ms : {1.0, 20.0, 30.0, 500.0}) {
      const TimeSurface time_surface(eta_ms);
      for (const SurfaceTone tone : {SurfaceTone::kSigned, SurfaceTone::kUnsigned}) {
        for (const Polarity p : {Polarity::kOff, Polarity::kOn}) {
          support::OwnedSurface owned(300, 1);
          std::vector<Event> events;
          const auto step_us = static_cast<std::int64_t>(eta_ms * 25);
          for (int x = 0; x < 300; ++x) events.push_back(support::event_at(x * step_us, x, 0, p));
          owned.surface.insert(events);
          const Timestamp t_ref{280 * step_us};  // the last are after it: age 0
          Picture picture(300, 1);
          REQUIRE(time_surface.render(owned.surface, t_ref, tone, picture.view()));
          for (int x = 0; x < 300; ++x) {
            const double age_us = static_cast<double>(t_ref.us - x * step_us);
            const double want = formula(tone, age_us, p == Polarity::kOn, eta_ms);
            CAPTURE(age_us);
            REQUIRE(std::abs(picture.at(0, x) - want) <= kWithin);
          }
        }
      }
    }
  }

  TEST_CASE("a pixel shows the newer of its polarities; without event it is neutral") {
    support::OwnedSurface owned(40, 30);
    owned.surface.insert(support::busy_stream(2, 2000, 40, 30, 0));
    const Timestamp t_ref = *owned.surface.newest();
    const TimeSurface time_surface(20.0);
    for (const SurfaceTone tone : {SurfaceTone::kSigned, SurfaceTone::kUnsigned}) {
      Picture picture(40, 30);
      REQUIRE(time_surface.render(owned.surface, t_ref, tone, picture.view()));
      int neutral = 0;
      for (int y = 0; y < 30; ++y) {
        for (int x = 0; x < 40; ++x) {
          const Newest newest = newest_of(owned.surface, x, y);
          std::optional<double> age_us;
          if (newest.t_us) age_us = static_cast<double>(t_ref.us - *newest.t_us);
          const int got = picture.at(y, x);
          REQUIRE(std::abs(got - formula(tone, age_us, newest.on, 20.0)) <= kWithin);
          if (!age_us) {
            REQUIRE(got == (tone == SurfaceTone::kSigned ? 128 : 0));
            ++neutral;
          }
        }
      }
      CHECK(neutral > 10);
    }
  }

  TEST_CASE("long after the last event, or far from it, all is neutral") {
    support::OwnedSurface owned(40, 30);
    const TimeSurface time_surface(20.0);
    Picture picture(40, 30);
    const auto all_neutral = [&](Timestamp t_ref) {
      std::fill(picture.grey.begin(), picture.grey.end(), std::uint8_t{77});
      REQUIRE(time_surface.render(owned.surface, t_ref, SurfaceTone::kSigned, picture.view()));
      return std::all_of(picture.grey.begin(), picture.grey.end(),
                         [](std::uint8_t g) { return g == 128; });
    };
    CHECK(all_neutral({0}));  // no event at all
    owned.surface.insert(support::busy_stream(2, 20'000, 40, 30, 0));
    const Timestamp newest = *owned.surface.newest();
    CHECK(!all_neutral(newest));
    CHECK(all_neutral(newest + time_surface.horizon()));
    // Where 32-bit ages have wrapped round.
    CHECK(all_neutral(newest + Duration{std::int64_t{1} << 32}));
    CHECK(all_neutral(newest - Duration{std::int64_t{1} << 32}));
  }

  TEST_CASE("the carried picture is that of each pixel's newest event, carried; the newest wins") {
    const auto s = std::make_unique<Scene>();
    struct Cell {
      std::int64_t t_us = -1;
      bool on = false;
    };
    std::vector<Cell> want(120 * 90);
    for (int y = 0; y < 90; ++y) {
      for (int x = 0; x < 120; ++x) {
        const Newest newest = newest_of(s->surface.surface, x, y);
        if (!newest.t_us || s->slices.index(*newest.t_us) == s->slices.count) continue;
        const WarpedPixel at = s->warp.warp_pixel(static_cast<std::size_t>(y * 120 + x), s->slices,
                                                  s->slices.index(*newest.t_us));
        if (at == kOutsideGrid) continue;
        Cell& cell = want[static_cast<std::size_t>(at.y_px * 120 + at.x_px)];
        if (*newest.t_us > cell.t_us || (*newest.t_us == cell.t_us && newest.on))
          cell = {*newest.t_us, newest.on};
      }
    }
    for (const SurfaceTone tone : {SurfaceTone::kSigned, SurfaceTone::kUnsigned}) {
      Picture picture(120, 90);
      REQUIRE(s->time_surface.render(s->surface.surface, s->warp, s->slices, tone, HoleFill::kNone,
                                     picture.scratch, picture.view()));
      std::size_t off_by_more = 0;
      for (int y = 0; y < 90; ++y) {
        for (int x = 0; x < 120; ++x) {
          const Cell& cell = want[static_cast<std::size_t>(y * 120 + x)];
          std::optional<double> age_us;
          if (cell.t_us >= 0) age_us = static_cast<double>(s->t_ref.us - cell.t_us);
          off_by_more +=
              std::abs(picture.at(y, x) - formula(tone, age_us, cell.on, 20.0)) > kWithin ? 1U : 0U;
        }
      }
      // Stamps within 4 us of each other are one: then ON wins.
      CHECK(off_by_more <= 3);
    }
  }

  TEST_CASE("against carrying every event: few pixels differ, and those are older there") {
    const auto s = std::make_unique<Scene>();
    std::vector<WarpedPixel> warped(s->events.size());
    s->warp.warp(s->events, s->slices, warped);
    std::vector<EventVerdict> verdicts(s->events.size());
    support::OwnedSurface again(120, 90);
    again.surface.insert(s->events, verdicts);
    std::vector<int> literal(120 * 90, 0);
    for (std::size_t i = 0; i < s->events.size(); ++i) {  // in time order: the newest stays
      if (verdicts[i] != EventVerdict::kAccepted || warped[i] == kOutsideGrid) continue;
      const double age_us = static_cast<double>(s->t_ref.us - s->events[i].t.us);
      literal[static_cast<std::size_t>(warped[i].y_px * 120 + warped[i].x_px)] =
          static_cast<int>(std::lround(formula(SurfaceTone::kUnsigned, age_us, true, 20.0)));
    }
    Picture picture(120, 90);
    REQUIRE(s->time_surface.render(s->surface.surface, s->warp, s->slices, SurfaceTone::kUnsigned,
                                   HoleFill::kNone, picture.scratch, picture.view()));
    double difference = 0.0;
    double total = 0.0;
    std::size_t missing = 0;
    std::size_t lit = 0;
    for (std::size_t i = 0; i < literal.size(); ++i) {
      const int got = picture.grey[i];
      REQUIRE(got <= literal[i] + 2);  // never newer than the newest of all events
      difference += std::abs(got - literal[i]);
      total += literal[i];
      lit += literal[i] > 25 ? 1U : 0U;
      missing += literal[i] > 25 && got <= 25 ? 1U : 0U;
    }
    MESSAGE("of " << lit << " pixels with an event of the last 2.3 eta, " << missing
                  << " are missing; mean grey lower by " << 100.0 * difference / total << " %");
    CHECK(static_cast<double>(missing) < 0.25 * static_cast<double>(lit));
  }

  TEST_CASE("a hole between two opposite neighbours takes the newer; nothing else is touched") {
    // So slow a decay that what has fired can be told from what has not.
    const auto s = std::make_unique<Scene>(70.0);
    Picture plain(120, 90);
    Picture filled(120, 90);
    REQUIRE(s->time_surface.render(s->surface.surface, s->warp, s->slices, SurfaceTone::kUnsigned,
                                   HoleFill::kNone, plain.scratch, plain.view()));
    REQUIRE(s->time_surface.render(s->surface.surface, s->warp, s->slices, SurfaceTone::kUnsigned,
                                   HoleFill::kBetween, filled.scratch, filled.view()));
    std::size_t holes = 0;
    for (int y = 0; y < 90; ++y) {
      for (int x = 0; x < 120; ++x) {
        int want = plain.at(y, x);
        const bool inner = x > 0 && y > 0 && x < 119 && y < 89;
        if (want == 0 && inner) {
          const int row = std::min(plain.at(y, x - 1), plain.at(y, x + 1)) == 0
                              ? 0
                              : std::max(plain.at(y, x - 1), plain.at(y, x + 1));
          const int column = std::min(plain.at(y - 1, x), plain.at(y + 1, x)) == 0
                                 ? 0
                                 : std::max(plain.at(y - 1, x), plain.at(y + 1, x));
          want = std::max(row, column);
          holes += want != 0 ? 1U : 0U;
        }
        REQUIRE(filled.at(y, x) == want);
      }
    }
    CHECK(holes > 50);
  }

  TEST_CASE("a picture or scratch of the wrong size is refused and left alone") {
    const auto s = std::make_unique<Scene>();
    Picture small(119, 90);
    CHECK(
        !s->time_surface.render(s->surface.surface, s->t_ref, SurfaceTone::kSigned, small.view()));
    CHECK(!s->time_surface.render(s->surface.surface, s->warp, s->slices, SurfaceTone::kSigned,
                                  HoleFill::kNone, small.scratch, small.view()));
    Picture right(120, 90);
    CHECK(!s->time_surface.render(s->surface.surface, s->warp, s->slices, SurfaceTone::kSigned,
                                  HoleFill::kNone, std::span(right.scratch).first(119 * 90),
                                  right.view()));
    for (const std::uint8_t g : right.grey) REQUIRE(g == 77);
    for (const std::uint8_t g : small.grey) REQUIRE(g == 77);
  }
}

}  // namespace pled
