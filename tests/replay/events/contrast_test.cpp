#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "support/events/event_footage.hpp"

namespace pled {
namespace {

using support::EventFootage;

constexpr double kDegree_rad = std::numbers::pi / 180.0;

std::string recordings(const char* what) {
  const char* const folder = std::getenv("PLED_RECORDINGS");
  if (folder != nullptr && *folder != '\0') return folder;
  MESSAGE("skipped, PLED_RECORDINGS is not set: " << std::string(what));
  return {};
}

struct Median {
  double q10 = 0.0, q50 = 0.0, q90 = 0.0;

  explicit Median(std::vector<double> values) {
    REQUIRE(!values.empty());
    std::sort(values.begin(), values.end());
    q10 = values[values.size() / 10];
    q50 = values[values.size() / 2];
    q90 = values[values.size() * 9 / 10];
  }
};

/// DAVIS240C behind 4.5 mm, pixels of 18.5 um. AEDAT 2.0 has the axes of the inertial chip; rpg_dvs
/// negates its x and z to have those of the camera (x right, y down, z forward), that is a half
/// turn about y. The file itself agrees: gravity is felt along -y, up, and the roll that sharpens
/// the picture has the other sign than the gyro's z (below).
EventFootage disk(const std::string& folder) {
  return {folder + "/formats/aedat2/IMU_rotDisk.aedat", 4.5e-3 / 18.5e-6,
          Eigen::Quaterniond(0.0, 0.0, 1.0, 0.0)};
}

/// The chip feels gravity on z all the same while it goes round from y to x. So the camera turns,
/// not the disk, and about z alone: what the gyro says steadily on x and y are its offsets.
Eigen::Vector3d offsets_of_disk(const EventFootage& footage) {
  Eigen::Vector3d bias_radps = footage.mean_rate_radps();
  bias_radps.z() = 0.0;  // not to be told from the roll
  return bias_radps;
}

/// The steady roll of largest contrast, to 0.25 deg/s, among those up to 60 deg/s either way.
double sharpest_roll_radps(const EventFootage& footage, std::span<const Event> window) {
  double best_radps = 0.0;
  double best = 0.0;
  const auto scan = [&](double middle_degps, double reach_degps, double step_degps) {
    for (double r = middle_degps - reach_degps; r <= middle_degps + reach_degps; r += step_degps) {
      const double contrast = footage.contrast_by_roll(window, r * kDegree_rad);
      if (!(contrast > best)) continue;
      best = contrast;
      best_radps = r * kDegree_rad;
    }
  };
  scan(0.0, 60.0, 4.0);
  scan(best_radps / kDegree_rad, 4.0, 0.25);
  return best_radps;
}

/// Mean difference between the first and the last frame where nothing fired.
double change_of_quiet_pixels_grey(const support::Played& played) {
  REQUIRE(played.pixels.size() > 1);
  const std::vector<std::uint8_t>& first = played.pixels.front();
  const std::vector<std::uint8_t>& last = played.pixels.back();
  REQUIRE(first.size() == last.size());
  const auto width = static_cast<std::size_t>(played.frames.front().image.width);
  std::vector<bool> fired(first.size());
  for (const Event& e : played.events) fired.at(e.y_px * width + e.x_px) = true;
  double sum = 0.0;
  double n = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (fired[i]) continue;
    sum += std::abs(first[i] - last[i]);
    ++n;
  }
  return sum / n;
}

/// How far the direction of the felt gravity turned about z, from the first tenth of a second to
/// the last, rad.
double gravity_turned_rad(std::span<const ImuSample> samples) {
  const auto direction_rad = [&](Timestamp from, Timestamp to) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const ImuSample& s : samples)
      if (s.t >= from && s.t <= to) sum += Eigen::Map<const Eigen::Vector3d>(s.accel_mps2.data());
    return std::atan2(sum.y(), sum.x());
  };
  const Timestamp first = samples.front().t;
  const Timestamp last = samples.back().t;
  const Duration tenth{100'000};
  return std::remainder(direction_rad(last - tenth, last) - direction_rad(first, first + tenth),
                        2.0 * std::numbers::pi);
}

}  // namespace

TEST_SUITE("events.contrast") {
  TEST_CASE("the gyro sharpens the picture of a camera that rolls before a disk") {
    const std::string folder = recordings("contrast of IMU_rotDisk");
    if (folder.empty()) return;
    const EventFootage footage = disk(folder);
    const Eigen::Vector3d bias_radps = offsets_of_disk(footage);
    for (const std::int64_t length_us : {50'000, 100'000}) {
      std::vector<double> by_gyro;
      std::vector<double> by_raw_gyro;
      std::vector<double> wrong_way;
      for (const auto window : footage.windows(Duration{length_us})) {
        const double before = footage.contrast(window);
        by_gyro.push_back(footage.contrast_by_gyro(window, bias_radps) / before);
        by_raw_gyro.push_back(footage.contrast_by_gyro(window, Eigen::Vector3d::Zero()) / before);
        wrong_way.push_back(footage.contrast_by_roll(window, footage.mean_rate_radps(window).z()) /
                            before);
      }
      const Median gain(by_gyro);
      MESSAGE("IMU_rotDisk, " << by_gyro.size() << " windows of " << length_us / 1000
                              << " ms: contrast gain median " << gain.q50 << " (10 % " << gain.q10
                              << ", 90 % " << gain.q90 << "), offsets of x and y left in "
                              << Median(by_raw_gyro).q50 << ", turned the wrong way "
                              << Median(wrong_way).q50);
      CHECK(gain.q50 > (length_us == 50'000 ? 1.03 : 1.15));
      CHECK(gain.q10 > 1.0);
      CHECK(Median(wrong_way).q50 < 1.0);
    }
  }

  TEST_CASE("the roll that sharpens most is the gyro's") {
    const std::string folder = recordings("the sharpest roll of IMU_rotDisk");
    if (folder.empty()) return;
    const EventFootage footage = disk(folder);
    std::vector<double> difference_degps;
    double sharpest_degps = 0.0;
    double gyro_degps = 0.0;
    const auto windows = footage.windows(Duration{100'000});
    for (const auto window : windows) {
      const double sharpest = -sharpest_roll_radps(footage, window) / kDegree_rad;
      const double gyro = footage.mean_rate_radps(window).z() / kDegree_rad;
      difference_degps.push_back(sharpest - gyro);
      sharpest_degps += sharpest / static_cast<double>(windows.size());
      gyro_degps += gyro / static_cast<double>(windows.size());
    }
    const Median difference(difference_degps);
    MESSAGE("IMU_rotDisk: sharpest roll "
            << sharpest_degps << " deg/s, gyro " << gyro_degps << ", difference in a window median "
            << difference.q50 << " (10 % " << difference.q10 << ", 90 % " << difference.q90 << ")");
    CHECK(sharpest_degps > 25.0);
    CHECK(sharpest_degps < 34.0);
    CHECK(std::abs(sharpest_degps - gyro_degps) < 1.5);
    CHECK(std::abs(difference.q50) < 1.5);
    CHECK(difference.q10 > -5.0);
    CHECK(difference.q90 < 5.0);

    // At rest a body that turns by +z feels gravity turn by -z.
    const auto& imu = footage.played().imu;
    const double by_gravity_degps =
        -gravity_turned_rad(imu) / kDegree_rad / ((imu.back().t - imu.front().t).seconds() - 0.1);
    MESSAGE("the same by the turning of gravity: " << by_gravity_degps << " deg/s");
    CHECK(std::abs(by_gravity_degps - sharpest_degps) < 2.0);
  }

  // Nothing in this file can be sharpened: the camera stands, its events are cars that drive by.
  TEST_CASE("a camera that stands beside a street gets the same picture by its gyro") {
    const std::string folder = recordings("contrast of the short DAVIS346 file");
    if (folder.empty()) return;
    // 6.5 mm behind pixels of 18.5 um; axes as the file has them.
    const EventFootage footage(folder + "/formats/aedat4/davis346_short.aedat4", 6.5e-3 / 18.5e-6,
                               Eigen::Quaterniond::Identity());
    const Eigen::Vector3d offset_radps = footage.mean_rate_radps();
    const double moved_grey = change_of_quiet_pixels_grey(footage.played());
    MESSAGE("DAVIS346: gyro steady at " << (offset_radps / kDegree_rad).transpose()
                                        << " deg/s; pixels without events change by " << moved_grey
                                        << " grey levels over the frames");
    CHECK(moved_grey < 3.0);
    for (const std::int64_t length_us : {30'000, 50'000, 150'000}) {
      std::vector<double> gain;
      std::vector<double> with_offset;
      for (const auto window : footage.windows(Duration{length_us})) {
        const double before = footage.contrast(window);
        CHECK((footage.mean_rate_radps(window) - offset_radps).norm() < 0.2 * kDegree_rad);
        gain.push_back(footage.contrast_by_gyro(window, offset_radps) / before);
        with_offset.push_back(footage.contrast_by_gyro(window, Eigen::Vector3d::Zero()) / before);
      }
      MESSAGE("DAVIS346, " << gain.size() << " windows of " << length_us / 1000
                           << " ms: contrast gain median " << Median(gain).q50
                           << ", with the gyro's offset left in " << Median(with_offset).q50);
      if (length_us == 150'000) CHECK(Median(with_offset).q50 < 0.99);
      CHECK(Median(gain).q50 == doctest::Approx(1.0).epsilon(0.005));
    }
  }
}

}  // namespace pled
