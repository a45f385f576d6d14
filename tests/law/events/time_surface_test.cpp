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
        scratch(TimeSurface::floats_needed(width, height), 1e30F) {}
  [[nodiscard]] ImageView<std::uint8_t> view() { return {grey.data(), width, height, width}; }
  [[nodiscard]] int at(int y, int x) const { return grey[static_cast<std::size_t>(y * width + x)]; }

  int width;
  int height;
  std::vector<std::uint8_t> grey;
  std::vector<float> scratch;
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
  Scene()
      : surface(120, 90), bearings(UndistortionTable::floats_needed(120, 90)), time_surface(20.0) {
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
    const Timestamp from = std::max(t_ref - time_surface.reach(Meeting::kNewest), *turn.oldest());
    REQUIRE(turn.slices(t_ref, from, t_ref, warp.slice_error_rad(), slices));
  }

  /// Calls visit(place on the grid, stamp, ON) for each pixel's newest event of either polarity
  /// that is younger than `reach` and falls into the grid.
  template <typename Visit>
  void each_carried(Duration reach, const Visit& visit) const {
    for (int y = 0; y < 90; ++y) {
      for (int x = 0; x < 120; ++x) {
        for (const Polarity p : {Polarity::kOff, Polarity::kOn}) {
          const std::optional<Timestamp> t = surface.surface.filtered(x, y, p);
          if (!t || t_ref - *t >= reach) continue;
          const std::size_t slice = slices.index(t->us);
          if (slice == slices.count) continue;
          const std::optional<Eigen::Vector2f> at =
              warp.carry_pixel(static_cast<std::size_t>(y * 120 + x), slices, slice);
          if (at) visit(*at, t->us, p == Polarity::kOn);
        }
      }
    }
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
    CHECK(all_neutral(newest + time_surface.reach(Meeting::kNewest)));
    // Where 32-bit ages have wrapped round.
    CHECK(all_neutral(newest + Duration{std::int64_t{1} << 32}));
    CHECK(all_neutral(newest - Duration{std::int64_t{1} << 32}));
  }

  TEST_CASE("the carried picture is that of each pixel's newest events, carried; the newest wins") {
    const auto s = std::make_unique<Scene>();
    struct Cell {
      std::int64_t t_us = -1;
      bool on = false;
    };
    std::vector<Cell> want(120 * 90);
    s->each_carried(s->time_surface.reach(Meeting::kNewest),
                    [&](const Eigen::Vector2f& at, std::int64_t t_us, bool on) {
                      const auto x = static_cast<int>(std::floor(at.x() + 0.5F));
                      const auto y = static_cast<int>(std::floor(at.y() + 0.5F));
                      Cell& cell = want[static_cast<std::size_t>(y * 120 + x)];
                      if (t_us > cell.t_us || (t_us == cell.t_us && on)) cell = {t_us, on};
                    });
    for (const SurfaceTone tone : {SurfaceTone::kSigned, SurfaceTone::kUnsigned}) {
      Picture picture(120, 90);
      REQUIRE(s->time_surface.render(s->surface.surface, s->warp, s->slices, tone, Meeting::kNewest,
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
      CHECK(off_by_more == 0);
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
                                   Meeting::kNewest, picture.scratch, picture.view()));
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

  TEST_CASE("the blended picture is the mean that its definition says, within 1.5 levels") {
    const auto s = std::make_unique<Scene>();
    for (const SurfaceTone tone : {SurfaceTone::kSigned, SurfaceTone::kUnsigned}) {
      struct Sums {
        double w = 0.0, we = 0.0, moment = 0.0;
      };
      std::vector<Sums> sums(120 * 90);
      s->each_carried(s->time_surface.reach(Meeting::kBlended), [&](const Eigen::Vector2f& at,
                                                                    std::int64_t t_us, bool on) {
        const double e = std::exp(-static_cast<double>(s->t_ref.us - t_us) / 20'000.0);
        for (int y = 0; y < 90; ++y) {
          const double wy = 1.0 - std::abs(static_cast<double>(at.y()) - y);
          if (wy <= 0.0) continue;
          for (int x = 0; x < 120; ++x) {
            const double w = wy * (1.0 - std::abs(static_cast<double>(at.x()) - x));
            if (w <= 0.0) continue;
            Sums& cell = sums[static_cast<std::size_t>(y * 120 + x)];
            cell.w += w;
            cell.we += w * e;
            cell.moment += w * e * (on || tone == SurfaceTone::kUnsigned ? e : -e);
          }
        }
      });
      Picture picture(120, 90);
      REQUIRE(s->time_surface.render(s->surface.surface, s->warp, s->slices, tone,
                                     Meeting::kBlended, picture.scratch, picture.view()));
      std::size_t lit = 0;
      for (std::size_t i = 0; i < sums.size(); ++i) {
        const double mean =
            sums[i].we > 0.0 ? sums[i].moment / sums[i].we * std::min(sums[i].w, 1.0) : 0.0;
        const double want = tone == SurfaceTone::kSigned ? 127.5 * (1.0 + mean) : 255.0 * mean;
        REQUIRE(std::abs(picture.grey[i] - want) <= 1.5);
        lit += std::abs(mean) > 0.1 ? 1U : 0U;
      }
      CHECK(lit > 2000);
    }
  }

  TEST_CASE("on the edge of the grid a blended event loses what falls beyond, and nothing breaks") {
    const auto s = std::make_unique<Scene>();
    support::OwnedSurface ring(120, 90);
    std::vector<Event> events;
    for (int x = 0; x < 120; ++x)
      for (const int y : {0, 89}) events.push_back(support::event_at(299'990, x, y));
    for (int y = 0; y < 90; ++y)
      for (const int x : {0, 119}) events.push_back(support::event_at(299'990, x, y));
    ring.surface.insert(events);
    Picture picture(120, 90);
    REQUIRE(s->time_surface.render(ring.surface, s->warp, s->slices, SurfaceTone::kSigned,
                                   Meeting::kBlended, picture.scratch, picture.view()));
    CHECK(picture.at(0, 60) > 240);
    CHECK(picture.at(89, 60) > 240);
    CHECK(picture.at(45, 0) > 240);
    CHECK(picture.at(45, 60) == 128);
  }

  TEST_CASE("a picture or scratch of the wrong size is refused and left alone") {
    const auto s = std::make_unique<Scene>();
    Picture small(119, 90);
    CHECK(
        !s->time_surface.render(s->surface.surface, s->t_ref, SurfaceTone::kSigned, small.view()));
    CHECK(!s->time_surface.render(s->surface.surface, s->warp, s->slices, SurfaceTone::kSigned,
                                  Meeting::kNewest, small.scratch, small.view()));
    Picture right(120, 90);
    CHECK(!s->time_surface.render(s->surface.surface, s->warp, s->slices, SurfaceTone::kSigned,
                                  Meeting::kNewest, std::span(right.scratch).first(4 * 119 * 90),
                                  right.view()));
    for (const std::uint8_t g : right.grey) REQUIRE(g == 77);
    for (const std::uint8_t g : small.grey) REQUIRE(g == 77);
  }
}

}  // namespace pled
