#include "pled_vins/events/active_surface.hpp"

#include <limits>

#include <doctest/doctest.h>

#include "support/events/surface_fixture.hpp"

namespace pled {
namespace {

using support::event_at;
using support::OwnedSurface;

constexpr std::int64_t kMinute_us = 60'000'000;

void insert(OwnedSurface& owned, const Event& e) { owned.surface.insert({&e, 1}); }

}  // namespace

TEST_SUITE("events.active_surface") {
  TEST_CASE("a surface without events has no stamp anywhere, whatever its memory held before") {
    OwnedSurface owned(4, 3);
    CHECK(!owned.surface.newest());
    CHECK(owned.surface.recent_size() == 0);
    owned.surface.insert({});
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 4; ++x) CHECK(!owned.surface.filtered(x, y, Polarity::kOn));
    CHECK(owned.surface.counts().in == 0);
  }

  TEST_CASE("events at the corners of the sensor count, those one pixel beyond do not") {
    OwnedSurface owned(20, 10);
    for (const auto& [x, y] : {std::pair{0, 0}, {19, 0}, {0, 9}, {19, 9}}) {
      insert(owned, event_at(1000, x, y));
      CHECK(owned.surface.filtered(x, y, Polarity::kOn) == Timestamp{1000});
    }
    for (const auto& [x, y] : {std::pair{20, 0}, {0, 10}, {65535, 65535}, {19, 10}})
      insert(owned, event_at(2000, x, y));
    CHECK(owned.surface.counts().outside == 4);
    CHECK(owned.surface.newest() == Timestamp{1000});
  }

  TEST_CASE("a repetition within kappa is redundant, one microsecond more or a flip is not") {
    OwnedSurface owned(2, 2);
    const std::array events{event_at(0, 0, 0),      event_at(10'000, 0, 0),
                            event_at(20'001, 0, 0), event_at(20'002, 0, 0, Polarity::kOff),
                            event_at(20'003, 0, 0), event_at(20'004, 0, 0)};
    std::array<EventVerdict, events.size()> verdicts{};
    owned.surface.insert(events, verdicts);
    CHECK(verdicts[0] == EventVerdict::kAccepted);
    CHECK(verdicts[1] == EventVerdict::kRedundant);
    CHECK(verdicts[2] == EventVerdict::kAccepted);  // 10.001 ms after the one before
    CHECK(verdicts[3] == EventVerdict::kAccepted);
    CHECK(verdicts[4] == EventVerdict::kAccepted);
    CHECK(verdicts[5] == EventVerdict::kRedundant);
  }

  TEST_CASE("a stamp that goes back is counted and changes nothing") {
    OwnedSurface owned(4, 4);
    insert(owned, event_at(5000, 1, 1));
    insert(owned, event_at(4999, 2, 2));
    CHECK(owned.surface.counts().strange_stamp == 1);
    CHECK(!owned.surface.filtered(2, 2, Polarity::kOn));
    insert(owned, event_at(5000, 2, 2));
    CHECK(owned.surface.filtered(2, 2, Polarity::kOn) == Timestamp{5000});
  }

  TEST_CASE("lone wild stamps do no harm; a clock that was set is believed after 64 events") {
    constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
    constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
    OwnedSurface owned(4, 4);
    insert(owned, event_at(5'000'000, 1, 1));
    for (const std::int64_t wild : {kMax, kMin, std::int64_t{0}, std::int64_t{1} << 40}) {
      insert(owned, event_at(wild, 2, 2));
      CHECK(owned.surface.newest() == Timestamp{5'000'000});
    }
    CHECK(owned.surface.counts().strange_stamp == 4);
    insert(owned, event_at(5'000'001, 1, 2));
    for (int i = 0; i < 63; ++i) insert(owned, event_at(1000 + i, 3, 3));
    CHECK(owned.surface.newest() == Timestamp{5'000'001});
    insert(owned, event_at(1063, 3, 3));
    CHECK(owned.surface.newest() == Timestamp{1063});
    CHECK(owned.surface.counts().restarts == 1);
    CHECK(owned.surface.counts().strange_stamp == 4 + 63);
    CHECK(!owned.surface.filtered(1, 1, Polarity::kOn));
    CHECK(owned.surface.filtered(3, 3, Polarity::kOn) == Timestamp{1063});
    CHECK(owned.surface.recent_size() == 1);
    // Stamps that are no instants never become the clock.
    for (int i = 0; i < 200; ++i) insert(owned, event_at(kMax, 3, 3));
    for (int i = 0; i < 200; ++i) insert(owned, event_at(kMin, 3, 3));
    CHECK(owned.surface.newest() == Timestamp{1063});
  }

  TEST_CASE("a pixel without event for an hour never looks new, also when its stamp wraps round") {
    for (const std::int64_t step_us : {kMinute_us / 60, 4 * kMinute_us}) {
      CAPTURE(step_us);
      OwnedSurface owned(6, 5);
      insert(owned, event_at(0, 2, 2));
      insert(owned, event_at(0, 4, 4, Polarity::kOff));
      std::int64_t t_us = 0;
      while (t_us < 150 * kMinute_us) {
        t_us += step_us;
        insert(owned, event_at(t_us, 0, 0));
        const std::optional<Timestamp> old = owned.surface.filtered(2, 2, Polarity::kOn);
        if (old) REQUIRE(old->us == 0);
        if (t_us > 32 * kMinute_us) REQUIRE(!old);
        // The age as the 32-bit stamps tell it.
        REQUIRE(owned.surface.filtered(0, 0, Polarity::kOn) == Timestamp{t_us});
      }
      CHECK(!owned.surface.filtered(4, 4, Polarity::kOff));
      CHECK(owned.surface.counts().strange_stamp == 0);
    }
  }

  TEST_CASE("an accepted stamp stays old on a pixel that goes on firing redundantly for an hour") {
    OwnedSurface owned(2, 2);
    std::int64_t t_us = 0;
    insert(owned, event_at(0, 1, 1));
    for (; t_us < 80 * kMinute_us; t_us += 9'999) insert(owned, event_at(t_us, 1, 1));
    const std::optional<Timestamp> stamp = owned.surface.filtered(1, 1, Polarity::kOn);
    REQUIRE(stamp);
    CHECK(t_us - stamp->us > 17 * kMinute_us);
    CHECK(t_us - stamp->us < 30 * kMinute_us);
  }

  TEST_CASE("a pixel above the rate is ignored until it rests; its neighbours are not") {
    OwnedSurface owned(8, 8);  // 1 kHz over 16 events
    std::array<EventVerdict, 1> verdict{};
    const auto told = [&](const Event& e) {
      owned.surface.insert({&e, 1}, verdict);
      return verdict[0];
    };
    const auto flip = [](int i) { return i % 2 == 0 ? Polarity::kOn : Polarity::kOff; };
    std::int64_t t_us = 0;
    int heard = 0;
    for (int i = 0; i < 5000; ++i, t_us += 200) {  // 5 kHz for a second
      heard += told(event_at(t_us, 3, 3, flip(i))) == EventVerdict::kAccepted ? 1 : 0;
      if (i % 100 == 0) CHECK(told(event_at(t_us, 4, 3)) == EventVerdict::kAccepted);
    }
    // Each event adds 1 ms to the tank and 0.2 ms drain: 16 ms are exceeded by the 20th.
    CHECK(heard == 19);
    CHECK(owned.surface.counts().hot == 5000 - 19);
    // 32 ms in the tank at most: after 17 ms of rest there is room for this event.
    CHECK(told(event_at(t_us + 17'000, 3, 3, flip(0))) == EventVerdict::kAccepted);
    // At 500 Hz a pixel is never hot.
    for (int i = 0; i < 1000; ++i)
      CHECK(told(event_at(t_us + 20'000 + 2000 * i, 6, 6, flip(i))) == EventVerdict::kAccepted);
  }

  TEST_CASE(
      "a burst of a hundred thousand events with one stamp on one pixel is counted, not kept") {
    OwnedSurface owned(8, 8);
    const std::vector<Event> burst(100'000, event_at(1000, 3, 3));
    owned.surface.insert(burst);
    CHECK(owned.surface.counts().accepted == 1);
    CHECK(owned.surface.counts().hot == 100'000 - 16);
    CHECK(owned.surface.recent_size() == 1);
  }

  TEST_CASE("the ring holds the newest 8191 accepted events") {
    OwnedSurface owned(64, 64);
    for (int i = 0; i < 20'000; ++i) insert(owned, event_at(20'000 * i, i % 64, i / 64 % 64));
    REQUIRE(owned.surface.recent_size() == limits::kEventRing - 1);
    for (int i = 0; i < 8191; ++i) {
      const RecentEvent& e = owned.surface.recent(static_cast<std::size_t>(i));
      REQUIRE(owned.surface.full_stamp(e.t_us) == Timestamp{20'000LL * (19'999 - i)});
      REQUIRE(e.x_px() == (19'999 - i) % 64);
    }
  }
}

}  // namespace pled
