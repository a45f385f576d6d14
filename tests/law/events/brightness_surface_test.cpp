#include "pled_vins/events/brightness_surface.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <doctest/doctest.h>

namespace {

using namespace pled;

constexpr int kWidth = 24;
constexpr int kHeight = 16;
constexpr double kTau_ms = 300.0;

struct Fixture {
  std::vector<BrightnessPixel> pixels =
      std::vector<BrightnessPixel>(static_cast<std::size_t>(kWidth) * kHeight);
  BrightnessSurface surface{kTau_ms, kWidth, kHeight, pixels};
  std::vector<std::uint8_t> grey =
      std::vector<std::uint8_t>(static_cast<std::size_t>(kWidth) * kHeight, 77);

  void insert(std::span<const Event> events, EventVerdict verdict = EventVerdict::kAccepted) {
    const std::vector<EventVerdict> verdicts(events.size(), verdict);
    surface.insert(events, verdicts);
  }
  std::uint8_t at(int x, int y, Timestamp t) {
    REQUIRE(surface.render(t, {grey.data(), kWidth, kHeight, kWidth}));
    return grey[static_cast<std::size_t>(y * kWidth + x)];
  }
};

Event event(std::int64_t us, int x, int y, bool on) {
  return {{us},
          static_cast<std::uint16_t>(x),
          static_cast<std::uint16_t>(y),
          on ? Polarity::kOn : Polarity::kOff};
}

}  // namespace

TEST_SUITE("events.brightness_surface") {
  TEST_CASE("grey is 128 plus the decayed steps and the one on its way, for random streams") {
    std::mt19937_64 random(5);
    Fixture f;
    std::vector<Event> events;
    std::int64_t t_us = 4'294'000'000;  // across the wrap of 32 bits
    for (int k = 0; k < 4000; ++k) {
      t_us += static_cast<std::int64_t>(random() % 900);
      events.push_back(event(t_us, static_cast<int>(random() % kWidth),
                             static_cast<int>(random() % kHeight), random() % 3 != 0));
    }
    f.insert(events);
    const Timestamp t_ref{t_us + 20'000};
    REQUIRE(f.surface.render(t_ref, {f.grey.data(), kWidth, kHeight, kWidth}));
    std::vector<double> want(f.grey.size(), 0.0);
    std::vector<double> pending(want.size(), 0.0);
    for (const Event& e : events) {
      const auto at = static_cast<std::size_t>(e.y_px * kWidth + e.x_px);
      const double p = e.polarity == Polarity::kOn ? 1.0 : -1.0;
      const double age = static_cast<double>(t_ref.us - e.t.us) / (kTau_ms * 1e3);
      want[at] += p * std::exp(-age);
      pending[at] = p * std::exp(-3.0 * age);  // of the pixel's last event
    }
    for (std::size_t i = 0; i < want.size(); ++i) want[i] += pending[i];
    for (std::size_t i = 0; i < want.size(); ++i) {
      CAPTURE(i);
      const double grey = std::clamp(
          128.0 + static_cast<double>(BrightnessSurface::kGreyPerStep) * want[i], 0.0, 255.0);
      // A table step is 0.8 % of tau; errors of the steps between a pixel's events add up to at
      // most half of that of its level, and the grey is rounded.
      CHECK(std::abs(static_cast<double>(f.grey[i]) - grey) < 2.0);
    }
  }

  TEST_CASE("splitting a stream anywhere gives the same picture") {
    std::mt19937_64 random(6);
    std::vector<Event> events;
    for (int k = 0; k < 500; ++k)
      events.push_back(event(100 * k, static_cast<int>(random() % kWidth),
                             static_cast<int>(random() % kHeight), (random() & 1U) != 0));
    Fixture whole, split;
    whole.insert(events);
    for (std::size_t i = 0; i < events.size();) {
      const std::size_t n = std::min<std::size_t>(1 + random() % 40, events.size() - i);
      split.insert(std::span(events).subspan(i, n));
      i += n;
    }
    (void)whole.at(0, 0, {60'000});
    (void)split.at(0, 0, {60'000});
    CHECK(whole.grey == split.grey);
  }

  TEST_CASE("a still picture fades to the middle, and does not come back when stamps wrap") {
    Fixture f;
    f.insert(std::vector<Event>(5, event(1000, 3, 4, true)));
    CHECK(f.at(3, 4, {1000}) == 236);            // 128 + (5 + 1) * 18
    CHECK(f.at(3, 4, {1000 + 300'000}) == 162);  // 128 + 18 (5 / e + 1 / e^3)
    CHECK(f.at(3, 4, {1000 + 3'000'000}) == 128);
    CHECK(f.at(3, 4, {1000 + (std::int64_t{1} << 32)}) == 128);
  }

  TEST_CASE("hot and dropped events leave no trace, and no stream drives a pixel away for good") {
    Fixture f;
    f.insert(std::vector<Event>(9, event(1000, 3, 4, true)), EventVerdict::kHot);
    f.insert(std::vector<Event>(9, event(1000, 3, 4, true)), EventVerdict::kDropped);
    CHECK(f.at(3, 4, {1000}) == 128);
    f.insert(std::vector<Event>(100'000, event(2000, 5, 5, false)));
    CHECK(f.at(5, 5, {2000}) == 0);
    // 64 steps at most: after 3.5 tau 64 / e^3.5 = 1.93 steps are left.
    CHECK(std::abs(f.at(5, 5, {2000 + 1'050'000}) - (128 - 18 * 1.93)) < 2.0);
  }

  TEST_CASE("a picture of another size is refused and left alone") {
    Fixture f;
    CHECK_FALSE(f.surface.render({0}, {f.grey.data(), kWidth - 1, kHeight, kWidth}));
    CHECK(f.grey[0] == 77);
  }
}
