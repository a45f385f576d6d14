#include "pled_vins/events/active_surface.hpp"

#include <cstring>

#include <doctest/doctest.h>

#include "support/events/surface_fixture.hpp"
#include "support/events/surface_reference.hpp"

namespace pled {
namespace {

constexpr int kWidth = 16;
constexpr int kHeight = 12;

void check_equal(const ActiveSurface& surface, const support::SurfaceReference& reference) {
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (const Polarity p : {Polarity::kOff, Polarity::kOn}) {
        const std::optional<Timestamp> got = surface.filtered(x, y, p);
        const auto& want = reference.at(y, x).filtered_us[static_cast<std::size_t>(p)];
        REQUIRE(got.has_value() == want.has_value());
        if (want) REQUIRE(got->us == *want);
      }
    }
  }
  REQUIRE(surface.recent_size() == std::min(reference.accepted.size(), limits::kEventRing - 1));
  for (std::size_t i = 0; i < surface.recent_size(); ++i) {
    const Event& want = reference.accepted[reference.accepted.size() - 1 - i];
    const RecentEvent& got = surface.recent(i);
    REQUIRE(surface.full_stamp(got.t_us) == want.t);
    REQUIRE(got.x_px() == want.x_px);
    REQUIRE(got.y_px() == want.y_px);
    REQUIRE(got.polarity() == static_cast<std::size_t>(want.polarity));
  }
}

}  // namespace

TEST_SUITE("events.active_surface.law") {
  TEST_CASE("every verdict, stamp and recent event is that of the definition") {
    const std::int64_t wraps_us = (std::int64_t{1} << 32) - 300'000;
    for (const std::int64_t begin_us : {std::int64_t{0}, wraps_us, std::int64_t{-5'000'000}}) {
      for (const double hot_rate_hz : {1000.0, 4000.0, 100000.0}) {
        CAPTURE(begin_us);
        CAPTURE(hot_rate_hz);
        EventConfig config;
        config.hot_rate_hz = hot_rate_hz;
        support::OwnedSurface owned(kWidth, kHeight, config);
        support::SurfaceReference reference(config, kWidth, kHeight);
        const std::vector<Event> events =
            support::busy_stream(7, 30'000, kWidth, kHeight, begin_us);
        std::vector<EventVerdict> verdicts(events.size(), EventVerdict::kDropped);
        owned.surface.insert(events, verdicts);
        std::size_t hot = 0;
        for (std::size_t i = 0; i < events.size(); ++i) {
          const EventVerdict want = reference.insert(events[i]);
          REQUIRE(verdicts[i] == want);
          hot += want == EventVerdict::kHot ? 1U : 0U;
        }
        check_equal(owned.surface, reference);
        CHECK(owned.surface.counts().hot == hot);
        CHECK(owned.surface.counts().in == events.size());
        CHECK(owned.surface.counts().accepted == reference.accepted.size());
        CHECK(owned.surface.counts().strange_stamp == 0);
        if (hot_rate_hz == 1000.0) CHECK(hot > 100);  // the stream has hot runs
      }
    }
  }

  TEST_CASE("how events are split into packets makes no difference to any bit") {
    std::vector<Event> events = support::busy_stream(3, 20'000, kWidth, kHeight, 1'000'000);
    // Stamps that go back, events off the sensor, and a clock that jumps for good.
    for (std::size_t i = 100; i < events.size(); i += 97) events[i].t.us -= 5000;
    for (std::size_t i = 50; i < events.size(); i += 211) events[i].x_px = kWidth;
    for (std::size_t i = 15'000; i < events.size(); ++i) events[i].t.us -= 900'000;
    support::OwnedSurface whole(kWidth, kHeight);
    whole.surface.insert(events);
    CHECK(whole.surface.counts().restarts == 1);
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      support::OwnedSurface split(kWidth, kHeight);
      support::in_packets(seed, events,
                          [&](std::span<const Event> packet) { split.surface.insert(packet); });
      CHECK(std::memcmp(split.memory.data(), whole.memory.data(),
                        whole.memory.size() * sizeof(SurfacePixel)) == 0);
      REQUIRE(split.surface.recent_size() == whole.surface.recent_size());
      for (std::size_t i = 0; i < whole.surface.recent_size(); ++i) {
        REQUIRE(split.surface.recent(i).t_us == whole.surface.recent(i).t_us);
        REQUIRE(split.surface.recent(i).packed == whole.surface.recent(i).packed);
      }
      const SurfaceCounts a = split.surface.counts();
      const SurfaceCounts b = whole.surface.counts();
      CHECK(a.in == b.in);
      CHECK(a.accepted == b.accepted);
      CHECK(a.hot == b.hot);
      CHECK(a.outside == b.outside);
      CHECK(a.strange_stamp == b.strange_stamp);
      CHECK(a.restarts == b.restarts);
    }
  }

  TEST_CASE("telling the verdicts changes nothing else") {
    const std::vector<Event> events = support::busy_stream(5, 5000, kWidth, kHeight, 0);
    support::OwnedSurface told(kWidth, kHeight);
    support::OwnedSurface untold(kWidth, kHeight);
    std::vector<EventVerdict> verdicts(events.size());
    told.surface.insert(events, verdicts);
    untold.surface.insert(events);
    CHECK(std::memcmp(told.memory.data(), untold.memory.data(),
                      told.memory.size() * sizeof(SurfacePixel)) == 0);
  }
}

}  // namespace pled
