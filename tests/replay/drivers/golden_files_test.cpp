#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <string>

#include <doctest/doctest.h>

#include "drivers/decode/evt3_decoder.hpp"
#include "drivers/replay/raw_file_source.hpp"
#include "drivers/replay/raw_header.hpp"
#include "drivers/replay/recording_info.hpp"
#include "unit/drivers/aedat_reading.hpp"
#include "unit/drivers/evt3_words.hpp"

using namespace pled;
using namespace pled::replay;

namespace {

/// Folder of the development recordings, or empty: then say what is skipped.
std::string recordings(const char* what) {
  const char* const folder = std::getenv("PLED_RECORDINGS");
  if (folder != nullptr && *folder != '\0') return folder;
  MESSAGE("skipped, PLED_RECORDINGS is not set: " << std::string(what));
  return {};
}

RecordingInfo survey_of(const std::string& path) {
  Problems problems;
  const auto recording = Recording::open(path, problems);
  REQUIRE(recording.ok());
  const auto info = survey(recording.value(), problems, {});
  REQUIRE(info.ok());
  return info.value();
}

}  // namespace

TEST_SUITE("drivers.golden_files") {
  TEST_CASE("a real EVT3 file gives its published number of events within its true time") {
    const std::string folder = recordings("the EVT3 file of a 1280x720 sensor");
    if (folder.empty()) return;
    const std::string path = folder + "/formats/prophesee_raw/evt3.raw";
    const auto header = read_raw_header(path.c_str());
    REQUIRE(header.ok());
    CHECK(header.value().format == RawFormat::kEvt3);
    auto source =
        RawFileSource::open(path.c_str(), {static_cast<std::int64_t>(header.value().bytes), false});
    REQUIRE(source.ok());
    REQUIRE(source.value()->start().ok());
    Evt3Decoder decoder(1280, 720);
    std::size_t count = 0;
    std::int64_t first_us = std::numeric_limits<std::int64_t>::max();
    std::int64_t last_us = std::numeric_limits<std::int64_t>::min();
    while (true) {
      const auto chunk = source.value()->acquire(Duration{});
      if (!chunk.ok()) break;
      const auto events = support::decode_all(decoder, chunk.value().bytes);
      source.value()->release();
      count += events.size();
      for (const Event& event : events) {
        REQUIRE(event.t.us >= last_us);
        last_us = event.t.us;
        first_us = std::min(first_us, event.t.us);
      }
    }
    CHECK(count == 219'596);
    CHECK(decoder.faults().outside_sensor == 0);
    CHECK(decoder.faults().malformed == 0);
    CHECK(decoder.faults().gaps == 0);
    CHECK(decoder.faults().time_backwards > 0);
    // Nine steps back that each added 4096 us would make 37 ms more.
    CHECK(last_us - first_us < 10'000);
  }

  TEST_CASE("the AEDAT files have their published events, samples, frames and triggers") {
    const std::string folder = recordings("counts of the AEDAT 2.0 and 4.0 files");
    if (folder.empty()) return;
    struct Expected {
      const char* name;
      ImageSize size;
      std::uint64_t events;
      std::uint64_t on;
      double seconds;
      std::uint64_t imu;
      std::uint64_t frames;
      std::uint64_t triggers;
    };
    constexpr std::uint64_t kNotPublished = 0;
    for (const Expected& expected :
         {Expected{"aedat2/IMU_rotDisk.aedat", {240, 180}, 374'296, 163'098, 3.167, 7'384, 0, 0},
          Expected{
              "aedat4/davis346_short.aedat4", {346, 260}, 6'676, kNotPublished, 0.170, 160, 4, 17},
          Expected{
              "aedat4/dvxplorer.aedat4", {320, 240}, 111'954, kNotPublished, 0.590, 475, 0, 0}}) {
      CAPTURE(expected.name);
      const std::string path = folder + "/formats/" + expected.name;
      const RecordingInfo info = survey_of(path);
      CHECK(info.events.count == expected.events);
      CHECK(info.events.width == expected.size.width_px);
      CHECK(info.events.height == expected.size.height_px);
      CHECK(info.events.last_s - info.events.first_s ==
            doctest::Approx(expected.seconds).epsilon(0.005));
      CHECK(info.imu.count == expected.imu);
      CHECK(info.imu.gaps == 0);
      CHECK(info.frames.count == expected.frames);
      CHECK(info.triggers.count == expected.triggers);
      CHECK(info.problems.empty());
      Problems problems;
      const auto recording = Recording::open(path, problems);
      REQUIRE(recording.ok());
      CHECK(problems.empty());
      const support::Played played = support::play(recording.value());
      const auto on = std::count_if(played.events.begin(), played.events.end(),
                                    [](const Event& e) { return e.polarity == Polarity::kOn; });
      if (expected.on != kNotPublished) CHECK(static_cast<std::uint64_t>(on) == expected.on);
      CHECK(played.lost_packets + played.bad_samples + played.bad_frames == 0);
      CHECK(played.faults.time_backwards + played.faults.outside_sensor == 0);
      // Whatever the axes, the cameras stand or turn slowly: gravity is what is felt.
      double sum_mps2 = 0.0;
      for (const ImuSample& sample : played.imu)
        sum_mps2 += std::hypot(sample.accel_mps2[0], sample.accel_mps2[1], sample.accel_mps2[2]);
      CHECK(sum_mps2 / static_cast<double>(played.imu.size()) ==
            doctest::Approx(9.81).epsilon(0.1));
    }
  }

  TEST_CASE("the disk of the AEDAT 2.0 file turns as slowly as its gyro is known to say") {
    const std::string folder = recordings("the roll of IMU_rotDisk");
    if (folder.empty()) return;
    Problems problems;
    const auto recording = Recording::open(folder + "/formats/aedat2/IMU_rotDisk.aedat", problems);
    REQUIRE(recording.ok());
    const support::Played played = support::play(recording.value());
    // The fastest axis of the mean is the roll: 25 to 34 deg/s of it.
    std::array<double, 3> mean_degps{};
    for (const ImuSample& sample : played.imu)
      for (std::size_t axis = 0; axis < 3; ++axis)
        mean_degps[axis] += sample.gyro_radps[axis] * 180.0 / std::numbers::pi /
                            static_cast<double>(played.imu.size());
    MESSAGE("mean rate about x, y, z: " << mean_degps[0] << ", " << mean_degps[1] << ", "
                                        << mean_degps[2] << " deg/s");
    CHECK(std::abs(mean_degps[2]) > std::abs(mean_degps[0]));
    CHECK(std::abs(mean_degps[2]) > std::abs(mean_degps[1]));
    CHECK(std::abs(mean_degps[2]) > 20.0);
    CHECK(std::abs(mean_degps[2]) < 35.0);
  }

  TEST_CASE("the simulated recordings have their published event, frame and sample counts") {
    const std::string folder = recordings("counts of the simulated recordings");
    if (folder.empty()) return;
    struct Expected {
      const char* name;
      std::uint64_t events;
      double imu_hz;
      double seconds;
    };
    for (const Expected& expected : {Expected{"parking_none", 6'605'912, 200.0, 10.0},
                                     Expected{"parking_high", 9'300'108, 200.0, 10.0},
                                     Expected{"city_night_high", 6'156'449, 200.0, 10.0},
                                     Expected{"room_6dof", 7'228'350, 1000.0, 8.0}}) {
      CAPTURE(expected.name);
      const RecordingInfo info = survey_of(folder + "/simulated/" + expected.name);
      CHECK(info.events.count == expected.events);
      CHECK(info.events.width == 240);
      CHECK(info.events.height == 180);
      CHECK(info.events.last_s == doctest::Approx(expected.seconds).epsilon(0.01));
      CHECK(info.imu.rate_hz == doctest::Approx(expected.imu_hz));
      CHECK(info.imu.gaps == 0);
      CHECK(info.frames.rate_hz == doctest::Approx(20.0));
      CHECK(info.truth.present);
      CHECK(info.masks.present);
      CHECK(info.problems.empty());
    }
  }

  TEST_CASE("the real recordings open with their published sizes and rates") {
    const std::string folder = recordings("the real recordings");
    if (folder.empty()) return;
    const RecordingInfo euroc = survey_of(folder + "/real/euroc_v101_start");
    CHECK(euroc.frames.count == 50);
    CHECK(euroc.frames.width == 752);
    CHECK(euroc.imu.rate_hz == doctest::Approx(200.0));
    const RecordingInfo mav = survey_of(folder + "/real/euroc_v102_imu_truth");
    CHECK(mav.imu.rate_hz == doctest::Approx(200.0));
    CHECK(mav.truth.present);
    CHECK_FALSE(mav.frames.present);
    const RecordingInfo slider = survey_of(folder + "/real/davis240c_slider_depth");
    CHECK(slider.events.count == 50'000);
    CHECK(slider.frames.count == 87);
    const RecordingInfo room = survey_of(folder + "/real/room_handheld");
    CHECK(room.frames.width == 640);
    CHECK(room.frames.height == 360);
    CHECK(room.problems.empty());
    const RecordingInfo davis = survey_of(folder + "/real/davis346_rotation/one_axis");
    CHECK(davis.frames.width == 346);
    CHECK(davis.frames.rate_hz == doctest::Approx(40.0));
  }
}
