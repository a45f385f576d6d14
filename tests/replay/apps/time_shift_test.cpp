#include <cstdio>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/recording_fixture.hpp"

namespace {

using namespace pled::support;

/// The recording as a camera would have made it whose clock is `shift_s` behind the
/// inertial sensor's: t_imu = t_cam + shift. The first frame goes, lest its stamp be
/// negative.
void shift_camera(const RecordingCopy& recording, double shift_s, const std::string& told_s) {
  std::vector<std::string> images = recording.lines("images.txt");
  images.erase(images.begin());
  for (std::string& line : images) {
    char stamp[40];
    std::snprintf(stamp, sizeof stamp, "%.9f", std::stod(line) - shift_s);
    line.replace(0, line.find(' '), stamp);
  }
  recording.set_lines("images.txt", images);
  recording.replace("camchain.yaml", "timeshift_cam_imu: 0", "timeshift_cam_imu: " + told_s);
}

double ate_m(const RecordingCopy& recording) {
  const Outcome o = recording.replay();
  REQUIRE_MESSAGE(o.code == 0, o.err);
  return nlohmann::json::parse(recording.report())["accuracy"]["ate_rmse_m"].get<double>();
}

TEST_SUITE("apps.replay_time_shift") {
  TEST_CASE("a time shift that the calibration tells costs no accuracy, with either sign") {
    const RecordingCopy plain;
    shift_camera(plain, 0.0, "0");
    const double plain_m = ate_m(plain);
    for (const auto& [shift_s, told] : {std::pair{0.02, "0.02"}, std::pair{-0.02, "-0.02"}}) {
      CAPTURE(shift_s);
      const RecordingCopy shifted;
      shift_camera(shifted, shift_s, told);
      // Poses are carried back over the shift with constant speed and turning rate: at 4 m/s^2
      // that is within a 2^-1 * 4 * 0.02^2 = 0.8 mm. The rest is room for another start.
      CHECK(ate_m(shifted) < plain_m + 0.005);
      const std::vector<TumPose> poses = read_tum(shifted.out() / "trajectory.tum");
      REQUIRE(!poses.empty());
      CHECK(poses.back().t_s == doctest::Approx(2.45 - shift_s));  // the frames' own stamps
    }
  }
}

}  // namespace
