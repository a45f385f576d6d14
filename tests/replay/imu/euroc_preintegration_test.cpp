#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/imu/truth_check.hpp"

namespace {

using pled::ImuSample;
using pled::NavState;

/// The numbers of each line of a text file, commas or spaces between them; '#' starts a comment.
/// The first field, the stamp, comes as nanoseconds: it has more digits than a double.
struct Row {
  std::int64_t t_ns = 0;
  std::vector<double> values;
};

std::int64_t stamp_ns(const std::string& field) {
  const std::size_t dot = field.find('.');
  if (dot == std::string::npos) return std::stoll(field);
  std::string fraction = field.substr(dot + 1, 9);
  fraction.resize(9, '0');
  return std::stoll(field.substr(0, dot)) * 1'000'000'000 + std::stoll(fraction);
}

std::vector<Row> read_rows(const std::string& path) {
  std::ifstream file(path);
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') continue;
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::istringstream fields(line);
    std::string stamp;
    fields >> stamp;
    Row row{stamp_ns(stamp), {}};
    for (double v = 0.0; fields >> v;) row.values.push_back(v);
    rows.push_back(row);
  }
  return rows;
}

pled::Timestamp rounded(std::int64_t t_ns) { return {(t_ns + 500) / 1000}; }

/// Columns p (3), q w x y z, v (3), gyro bias (3), accelerometer bias (3).
std::vector<NavState> read_truth(const std::string& path) {
  std::vector<NavState> out;
  for (const Row& row : read_rows(path)) {
    REQUIRE(row.values.size() == 16);
    const std::vector<double>& v = row.values;
    NavState s;
    s.t = rounded(row.t_ns);
    s.p_wb = {v[0], v[1], v[2]};
    s.q_wb = Eigen::Quaterniond(v[3], v[4], v[5], v[6]).normalized();
    s.v_wb = {v[7], v[8], v[9]};
    s.bg = {v[10], v[11], v[12]};
    s.ba = {v[13], v[14], v[15]};
    out.push_back(s);
  }
  return out;
}

std::vector<ImuSample> read_imu(const std::string& path, bool gyro_first) {
  std::vector<ImuSample> out;
  const std::size_t gyro = gyro_first ? 0 : 3;
  const std::size_t accel = gyro_first ? 3 : 0;
  for (const Row& row : read_rows(path)) {
    REQUIRE(row.values.size() == 6);
    ImuSample s;
    s.t = rounded(row.t_ns);
    for (std::size_t k = 0; k < 3; ++k) {
      s.gyro_radps[k] = row.values[gyro + k];
      s.accel_mps2[k] = row.values[accel + k];
    }
    out.push_back(s);
  }
  return out;
}

}  // namespace

namespace {

// As the recordings' imu.yaml states it.
constexpr pled::ImuNoise kEurocNoise{.accel_density = 2.0e-3,
                                     .accel_walk = 3.0e-3,
                                     .gyro_density = 1.6968e-4,
                                     .gyro_walk = 1.9393e-5,
                                     .rate_hz = 200.0};

/// A check of plausibility: the reference's noise is known to a factor only, so these bounds are
/// wide and not those of chi squared. (Strict ones hold where the truth is exact: the Monte-Carlo
/// tests of the covariance, and `check-imu` on simulated recordings.)
///
/// Mean e^T P^-1 e per degree of freedom is 1 when all errors are as large as P says.
///
/// What P can know here: the IMU's own white noise is small (over 1 s 0.17 mrad, 2 mm/s, 1 mm), the
/// reference's is not. While the vehicle stands, its truth moves by 0.3 to 1 mm, 0.5 to 1.8 mrad
/// and 5 to 8 mm/s over 0.1 to 1 s, its gyro bias is off by 1 to 3 mrad/s, and gravity leans out of
/// its vertical by 4 mrad (V1_01) and 8 mrad (V1_02). P takes those values, measured in the
/// standing part without any integration.
///
/// Above: while flying the truth should be no worse than while standing; what P leaves out (rotor
/// vibration that the sampling folds back, scale and axis errors of the IMU near 0.5 %) may at most
/// triple the square. Below: the truth comes from a smoother that saw the same IMU, so its errors
/// at the two ends agree in part and cancel, and P counts a lean of the frame as an accelerometer
/// bias too; the square may be a tenth, and less would mean that P says nothing.
constexpr double kMaxNeesPerDof = 3.0;
constexpr double kMinNeesPerDof = 0.1;

void check_recording(const char* name, const std::vector<NavState>& truth,
                     const std::vector<ImuSample>& imu, std::size_t least_seconds) {
  REQUIRE_FALSE(truth.empty());
  REQUIRE_FALSE(imu.empty());
  for (const double interval_s : {0.1, 0.5, 1.0}) {
    CAPTURE(name);
    CAPTURE(interval_s);
    const auto u = pled::measure_standing_truth(truth, imu, interval_s);
    REQUIRE(u.has_value());
    const pled::PreintegrationCheck c =
        pled::check_preintegration(truth, imu, interval_s, kEurocNoise, *u);
    std::printf(
        "%s over %.1f s: %4zu intervals, NEES/dof %.3f (p %.2f, theta %.2f, v %.2f), "
        "rms %.2f mm %.3f mrad %.2f mm/s\n",
        name, interval_s, c.compared, c.mean_nees_per_dof, c.position_nees_per_dof,
        c.attitude_nees_per_dof, c.velocity_nees_per_dof, 1e3 * c.position_rms_m,
        1e3 * c.attitude_rms_rad, 1e3 * c.velocity_rms_mps);
    std::printf(
        "  truth while standing: %.2f mm, %.2f mrad, %.1f mm/s; gyro bias %.2f mrad/s; "
        "tilt %.1f mrad\n",
        1e3 * u->position_m, 1e3 * u->attitude_rad, 1e3 * u->velocity_mps, 1e3 * u->gyro_bias_radps,
        1e3 * u->frame_tilt_rad);
    CHECK(static_cast<double>(c.compared) * interval_s > static_cast<double>(least_seconds));
    for (const double nees : {c.mean_nees_per_dof, c.position_nees_per_dof, c.attitude_nees_per_dof,
                              c.velocity_nees_per_dof}) {
      CHECK(nees < kMaxNeesPerDof);
      CHECK(nees > kMinNeesPerDof);
    }
  }
}

}  // namespace

TEST_SUITE("imu.euroc_preintegration") {
  TEST_CASE(
      "real IMU data integrated between true states end plausibly near where the truth ends") {
    const char* root = std::getenv("PLED_RECORDINGS");
    if (root == nullptr) {
      MESSAGE(
          "skipped: PLED_RECORDINGS is unset (real/euroc_v101_start, real/euroc_v102_imu_truth)");
      return;
    }
    const std::string v101 = std::string(root) + "/real/euroc_v101_start/";
    const std::string v102 = std::string(root) + "/real/euroc_v102_imu_truth/mav0/";
    check_recording("V1_01", read_truth(v101 + "truth_with_velocity_and_biases_20hz.csv"),
                    read_imu(v101 + "imu.txt", false), 140);
    check_recording("V1_02", read_truth(v102 + "gt0/data.csv"),
                    read_imu(v102 + "imu0/data.csv", true), 37);
  }
}
