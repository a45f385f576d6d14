#include "src/sim/event_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/sim/trajectory.hpp"
#include "src/sim/renderer.hpp"
#include "tests/support/room_flight.hpp"

using namespace pled;
using namespace pled::sim;

namespace {

EventOptions ideal() {
  EventOptions o;
  o.mismatch = 0.0;
  o.refractory_s = 0.0;
  o.noise_rate_hz = 0.0;
  o.leak_rate_hz = 0.0;
  o.bandwidth_hz = 1e6;
  o.hot_share = 0.0;
  return o;
}

/// Radiance whose log_intensity() is `level`.
float radiance_of(double level) {
  const double dark = std::exp(static_cast<double>(EventModel::log_intensity(0.0F)));
  return static_cast<float>(std::exp(level) - dark);
}

/// One row of pixels taken along straight ramps of log intensity, from `from` to `to`.
std::vector<Event> ramp(const EventOptions& options, std::size_t width, double from, double to,
                        double duration_s, std::uint64_t seed = 1) {
  EventModel model{static_cast<int>(width), 1, options, seed};
  const std::vector<float> first(width, radiance_of(from)), last(width, radiance_of(to));
  model.start({0.0, first});
  std::vector<Event> events;
  model.advance_row(0, std::array{Exposure{duration_s, last}}, events);
  return events;
}

}  // namespace

TEST_SUITE("sim.event_model") {
  TEST_CASE("a ramp fires once per threshold, all of its sign, evenly in time") {
    for (const double sign : {1.0, -1.0}) {
      const std::vector<Event> events = ramp(ideal(), 1, -2.0, -2.0 + sign * 1.6, 0.1);
      // 8 thresholds from a reference up to one threshold away.
      CHECK(events.size() >= 7);
      CHECK(events.size() <= 9);
      for (std::size_t i = 0; i < events.size(); ++i) {
        CHECK(events[i].polarity == (sign > 0 ? Polarity::kOn : Polarity::kOff));
        if (i == 0) continue;
        // 0.2 of 1.6 in 100 ms: 12.5 ms; stamps are rounded to 1 us, references to float.
        CHECK(std::abs((events[i].t - events[i - 1].t).us - 12500) <= 2);
      }
    }
  }

  TEST_CASE("the refractory time is added between the events of a pixel") {
    EventOptions options = ideal();
    options.refractory_s = 0.005;
    const std::vector<Event> events = ramp(options, 1, -2.0, -0.4, 0.1);
    REQUIRE(events.size() >= 4);
    for (std::size_t i = 1; i < events.size(); ++i)
      CHECK(std::abs((events[i].t - events[i - 1].t).us - 17500) <= 2);
  }

  TEST_CASE("thresholds differ between pixels as configured") {
    EventOptions options = ideal();
    options.mismatch = 0.05;
    const EventModel model{200, 100, options, 9};
    double mean = 0.0, square = 0.0;
    for (int y = 0; y < 100; ++y)
      for (int x = 0; x < 200; ++x) {
        mean += model.threshold_on(y, x) / 20000.0;
        square += model.threshold_on(y, x) * model.threshold_on(y, x) / 20000.0;
      }
    CHECK(mean == doctest::Approx(0.2).epsilon(0.002));
    CHECK(std::sqrt(square - mean * mean) == doctest::Approx(0.2 * 0.05).epsilon(0.03));
  }

  TEST_CASE("in steady light noise alone fires, at its rate") {
    EventOptions options = ideal();
    CHECK(ramp(options, 1000, -1.0, -1.0, 10.0).empty());
    options.noise_rate_hz = 2.0;
    // Four times as frequent in the dark as in full light, linear between (v2e, section 3.3).
    for (const float radiance : {0.0F, 0.4F, 1.0F}) {
      const double level = static_cast<double>(EventModel::log_intensity(radiance));
      const std::vector<Event> events = ramp(options, 1000, level, level, 10.0);
      const double mean = 20000.0 * (1.0 - 0.75 * static_cast<double>(radiance));
      CHECK(std::abs(static_cast<double>(events.size()) - mean) < 3.0 * std::sqrt(mean));
    }
  }

  TEST_CASE("a leaking reference fires ON events at its rate, and hot pixels fire by themselves") {
    EventOptions options = ideal();
    options.leak_rate_hz = 0.5;
    EventModel model{1000, 1, options, 1};
    const std::vector<float> light(1000, 0.3F);
    model.start({0.0, light});
    std::vector<Event> events;
    for (int k = 1; k <= 8000; ++k) {
      const double t_s = k * 0.0025;
      model.advance_row(0, std::array{Exposure{t_s, light}}, events);
      model.advanced_to(t_s);
    }
    // A threshold each 2 s over 20 s, from anywhere between two thresholds: 9.5 to 10.
    CHECK(std::abs(static_cast<double>(events.size()) - 9900.0) < 600.0);
    for (const Event& e : events) REQUIRE(e.polarity == Polarity::kOn);

    options = ideal();
    options.hot_share = 0.01;
    options.hot_rate_hz = 50.0;
    const std::vector<Event> hot = ramp(options, 20000, -1.0, -1.0, 2.0, 3);
    // 200 pixels of 100 events: the number of pixels varies by 14, three deviations.
    CHECK(std::abs(static_cast<double>(hot.size()) - 20000.0) < 4500.0);
  }

  TEST_CASE("the photoreceptor's lag on a ramp does not depend on how often is rendered") {
    const double tau_s = 1.0 / (2.0 * std::acos(-1.0) * 300.0);
    for (const double step_s : {1e-4, 1e-3, 3e-3}) {
      CAPTURE(step_s);
      EventOptions options = ideal();
      options.bandwidth_hz = 300.0;
      EventModel model{1, 1, options, 1};
      // Bright, so that the corner is the nominal one: log light from 0 to 3 in 0.3 s.
      const auto light = [](double t_s) {
        return static_cast<float>(std::exp(10.0 * t_s)) - 0.02F;
      };
      model.start({0.0, std::vector<float>{light(0.0)}});
      std::vector<Event> events;
      const int steps = static_cast<int>(std::lround(0.3 / step_s));
      for (int k = 1; k <= steps; ++k) {
        const std::vector<float> now{light(k * step_s)};
        model.advance_row(0, std::array{Exposure{k * step_s, now}}, events);
        model.advanced_to(k * step_s);
      }
      REQUIRE(events.size() > 10);
      // Events lie on a line of one threshold each; where it meets the last event, the light had
      // that level one lag earlier. Thresholds are counted from the random reference at the start,
      // so two models tell it: with and without the filter.
      options.bandwidth_hz = 1e5;
      EventModel prompt{1, 1, options, 1};
      prompt.start({0.0, std::vector<float>{light(0.0)}});
      std::vector<Event> at_once;
      for (int k = 1; k <= steps; ++k) {
        const std::vector<float> now{light(k * step_s)};
        prompt.advance_row(0, std::array{Exposure{k * step_s, now}}, at_once);
        prompt.advanced_to(k * step_s);
      }
      const std::size_t last = std::min(events.size(), at_once.size()) - 1;
      const double lag_s = (events[last].t - at_once[last].t).seconds();
      CHECK(lag_s == doctest::Approx(tau_s).epsilon(0.05));
    }
  }

  TEST_CASE("a reference that leaked beyond its level fires ON although the light falls") {
    EventOptions options = ideal();
    options.leak_rate_hz = 10.0;
    EventModel model{1000, 1, options, 1};
    model.start({0.0, std::vector<float>(1000, 0.8F)});
    std::vector<Event> events;
    for (int k = 1; k <= 400; ++k) {  // the log light falls by a tenth of what the leak takes
      const std::vector<float> light(1000,
                                     static_cast<float>(0.82 * std::exp(-0.2 * 0.0025 * k) - 0.02));
      model.advance_row(0, std::array{Exposure{k * 0.0025, light}}, events);
      model.advanced_to(k * 0.0025);
    }
    std::size_t on = 0;
    for (const Event& e : events) on += e.polarity == Polarity::kOn ? 1U : 0U;
    CHECK(on == events.size());
    // 10 leaks less 0.2 / threshold = 1 a second, from anywhere between two thresholds.
    CHECK(static_cast<double>(on) == doctest::Approx(1000.0 * 8.5).epsilon(0.07));
  }

  TEST_CASE("the photoreceptor follows a step with its corner frequency, slower in the dark") {
    for (const float light : {0.8F, 0.1F}) {
      EventOptions options = ideal();
      options.bandwidth_hz = 50.0;
      options.threshold = 0.05;
      EventModel model{1, 1, options, 1};
      const std::vector<float> before{light}, after{2.0F * light};
      model.start({0.0, before});
      std::vector<Event> events;
      for (int k = 1; k <= 4000; ++k) {
        const double t_s = k * 1e-4;
        model.advance_row(0, std::array{Exposure{t_s, after}}, events);
        model.advanced_to(t_s);
      }
      REQUIRE(events.size() > 8);
      // Half of the step is passed after ln 2 / (2 pi f); the corner falls with the light, to a
      // twentieth at the least.
      const double corner_hz = 50.0 * std::min(1.0, 2.0 * static_cast<double>(light) + 0.05);
      const double half_s = std::log(2.0) / (2.0 * std::acos(-1.0) * corner_hz);
      const double seen_s = events[events.size() / 2].t.seconds();
      CHECK(seen_s == doctest::Approx(half_s).epsilon(0.2));
    }
  }

  TEST_CASE("events sum up to the change of log intensity between two moments of a flight") {
    SimulationOptions options = *preset("test");
    options.camera.width_px = 120;  // the left upper quarter of the sensor
    options.camera.height_px = 90;
    World world = make_room(2, MovingLevel::kNone);
    paint_boxes(world, 2);
    const Result<Renderer> renderer = Renderer::create(world, options.camera);
    REQUIRE(renderer.ok());
    const SineFlight flight = room_flight(2, StartKind::kMoving, 0.0);
    for (const bool clean : {true, false}) {
      CAPTURE(clean);
      const EventOptions sensor = clean ? ideal() : options.events;
      EventModel model{120, 90, sensor, 2};
      View view, first;
      const auto render = [&](double t_s, View& out) {
        renderer.value().render(flight.at(t_s).T_world_body * options.camera.T_body_cam, t_s, out);
      };
      render(1.0, first);
      model.start({1.0, first.radiance});
      std::vector<Event> events;
      for (int k = 1; k <= 50; ++k) {
        render(1.0 + k * 1e-3, view);
        for (int y = 0; y < 90; ++y)
          model.advance_row(y, std::array{Exposure{1.0 + k * 1e-3, view.radiance}}, events);
        model.advanced_to(1.0 + k * 1e-3);
      }
      REQUIRE(events.size() > 1000);
      std::vector<double> sum(first.radiance.size(), 0.0);
      for (const Event& e : events) {
        const std::size_t i = e.y_px * 120U + e.x_px;
        sum[i] += e.polarity == Polarity::kOn ? model.threshold_on(e.y_px, e.x_px)
                                              : -model.threshold_off(e.y_px, e.x_px);
      }
      double mean = 0.0, worst = 0.0, sxy = 0.0, sxx = 0.0, syy = 0.0;
      for (std::size_t i = 0; i < sum.size(); ++i) {
        const double change = static_cast<double>(EventModel::log_intensity(view.radiance[i])) -
                              static_cast<double>(EventModel::log_intensity(first.radiance[i]));
        const double error = sum[i] - change;
        mean += error / static_cast<double>(sum.size());
        worst = std::max(worst, std::abs(error));
        sxy += sum[i] * change;
        sxx += sum[i] * sum[i];
        syy += change * change;
      }
      MESSAGE("mean error ", mean, ", worst ", worst, ", correlation ", sxy / std::sqrt(sxx * syy));
      CHECK(std::abs(mean) < 0.02);
      CHECK(sxy / std::sqrt(sxx * syy) > 0.9);
      // Without rest and noise a pixel is never more than a threshold behind, at either end.
      if (clean) CHECK(worst < 0.4 + 1e-3);
    }
  }

  TEST_CASE("events are sent by time, then row, then column") {
    std::vector<Event> events{{{7}, 3, 2, Polarity::kOn},
                              {{7}, 9, 1, Polarity::kOn},
                              {{6}, 200, 170, Polarity::kOff},
                              {{7}, 1, 2, Polarity::kOff}};
    sort_as_sent(events);
    CHECK(events[0].x_px == 200);
    CHECK(events[1].x_px == 9);
    CHECK(events[2].x_px == 1);
    CHECK(events[3].x_px == 3);
  }
}
