#include "pled_vins/pipeline/rate_limit.hpp"

#include <map>
#include <random>
#include <vector>

#include <doctest/doctest.h>

namespace pled {
namespace {

Event at(std::int64_t t_us, std::uint16_t x) { return {{t_us}, x, 0, Polarity::kOn}; }

/// What is let through, and how much is not, one event after the other.
struct Kept {
  std::vector<std::uint16_t> x;
  std::uint64_t shed = 0;
};

Kept by_definition(const std::vector<Event>& events, std::size_t per_slot) {
  Kept kept;
  std::map<std::int64_t, std::size_t> taken;  // by 1.024 ms of their own time
  for (const Event& e : events) {
    const std::int64_t slot = e.t.us >= 0 ? e.t.us / 1024 : -((-e.t.us + 1023) / 1024);
    if (taken[slot]++ < per_slot) {
      kept.x.push_back(e.x_px);
    } else {
      ++kept.shed;
    }
  }
  return kept;
}

}  // namespace

TEST_SUITE("pipeline.rate_limit") {
  TEST_CASE("of each slot the first events pass and the rest is counted, in packets of any size") {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      std::mt19937_64 random(seed);
      std::vector<Event> events;
      std::int64_t t_us = -20'000;
      for (int i = 0; i < 20'000; ++i) {
        // Bursts of many a microsecond, quiet stretches, and jumps over slots.
        t_us += i / 2000 % 2 == 0 ? static_cast<std::int64_t>(random() % 3)
                                  : static_cast<std::int64_t>(random() % 40);
        if (random() % 500 == 0) t_us += 5000;
        events.push_back(at(t_us, static_cast<std::uint16_t>(i)));
      }
      const Kept want = by_definition(events, 150);
      REQUIRE(want.shed > 1000);
      for (const std::size_t packet : {std::size_t{1}, std::size_t{7}, std::size_t{20'000}}) {
        RateLimit limit(0.15);  // millions a second: 150 a slot
        std::vector<std::uint16_t> passed;
        for (std::size_t i = 0; i < events.size(); i += packet)
          limit.pass(std::span(events).subspan(i, std::min(packet, events.size() - i)),
                     [&](std::span<const Event> run) {
                       CHECK(!run.empty());
                       for (const Event& e : run) passed.push_back(e.x_px);
                     });
        CAPTURE(packet);
        CHECK(passed == want.x);
        CHECK(limit.shed() == want.shed);
      }
    }
  }

  TEST_CASE("below the rate nothing is shed, and nothing at all is nothing") {
    RateLimit limit(0.1);
    std::size_t passed = 0;
    const auto count = [&](std::span<const Event> run) { passed += run.size(); };
    limit.pass({}, count);
    for (std::int64_t ms = 0; ms < 50; ++ms) {
      const std::vector<Event> slot(100, at(ms * 1024, 1));
      limit.pass(slot, count);
    }
    CHECK(passed == 5000);
    CHECK(limit.shed() == 0);
  }

  TEST_CASE("stamps that go back lose no event without being counted") {
    RateLimit limit(0.1);
    std::mt19937_64 random(9);
    std::vector<Event> events;
    for (int i = 0; i < 3000; ++i)
      events.push_back(at(static_cast<std::int64_t>(random() % 20'000), 1));
    std::size_t passed = 0;
    limit.pass(events, [&](std::span<const Event> run) { passed += run.size(); });
    CHECK(passed + limit.shed() == events.size());
  }
}

}  // namespace pled
