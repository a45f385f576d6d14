#include "pled_vins/sim/options.hpp"

#include <cmath>
#include <limits>
#include <string_view>

#include <doctest/doctest.h>

using namespace pled::sim;

TEST_SUITE("sim.options") {
  TEST_CASE("every preset is within range and an unknown name gives none") {
    for (const std::string_view name : kPresetNames) {
      CAPTURE(name);
      REQUIRE(preset(name).has_value());
      CHECK(check(*preset(name)).key == nullptr);
    }
    CHECK_FALSE(preset("Demo").has_value());
  }

  TEST_CASE("the demo starts in motion and the still preset at rest") {
    CHECK(preset("demo")->start == StartKind::kMoving);
    CHECK(preset("demo")->moving != MovingLevel::kNone);
    CHECK(preset("still")->start == StartKind::kStill);
    CHECK(preset("test")->moving == MovingLevel::kNone);
  }

  TEST_CASE("a value that is not a number or out of range is named") {
    const SimulationOptions good = *preset("demo");
    SimulationOptions bad = good;
    bad.duration_s = std::numeric_limits<double>::quiet_NaN();
    CHECK(std::string_view(check(bad).key) == "duration");
    bad = good;
    bad.events.threshold = 0.0;
    CHECK(std::string_view(check(bad).key) == "events.threshold");
    bad = good;
    bad.frames.exposure_s = 0.06;  // longer than a frame at 20 Hz
    CHECK(std::string_view(check(bad).key) == "frames.exposure_s");
    bad = good;
    bad.frames.blur_samples = 4;
    CHECK(std::string_view(check(bad).key) == "frames.blur_samples");
    bad = good;
    bad.faults.camera_late_s = 0.3;
    CHECK(std::string_view(check(bad).key) == "faults.camera_late");
    bad = good;
    bad.bus.away_m = 0.5;
    CHECK(std::string_view(check(bad).key) == "bus.away");
    bad = good;
    bad.bus.stand_s = -1.0;
    CHECK(std::string_view(check(bad).key) == "bus.time");
    bad = good;
    bad.event_camera = camera_beside(bad.camera);
    CHECK(check(bad).key == nullptr);
    bad.event_camera->width_px = 16;
    CHECK(std::string_view(check(bad).key) == "camera.resolution");
  }

  TEST_CASE("daylight again gives the sensor of the day") {
    SimulationOptions night = *preset("night");
    set_daylight(night, Daylight::kDay);
    const SimulationOptions day = *preset("street");
    CHECK(night.frames.gain == day.frames.gain);
    CHECK(night.frames.exposure_s == day.frames.exposure_s);
    CHECK(night.frames.noise_grey == day.frames.noise_grey);
    CHECK(night.frames.blur_samples == day.frames.blur_samples);
    CHECK(night.daylight == day.daylight);
  }

  TEST_CASE("the camera sits 2 cm from the body and is turned by a degree") {
    const pled::CameraCalibration c = davis240c_camera();
    CHECK(c.T_body_cam.p.norm() == doctest::Approx(0.0208).epsilon(0.01));
    const double angle_rad = 2.0 * std::acos(std::abs(c.T_body_cam.q.w()));
    CHECK(angle_rad == doctest::Approx(0.0194).epsilon(0.01));
  }
}
