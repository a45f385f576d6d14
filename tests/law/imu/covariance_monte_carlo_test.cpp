#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <vector>

#include <Eigen/Cholesky>
#include <doctest/doctest.h>

#include "law/imu/hand_held_motion.hpp"
#include "pled_vins/imu/imu_history.hpp"
#include "pled_vins/imu/preintegration.hpp"
#include "pled_vins/imu/truth_check.hpp"

namespace {

using Eigen::Vector3d;
using pled::ImuSample;
using pled::NavState;

constexpr int kRuns = 500;
constexpr double kRate_hz = 200.0;
constexpr pled::ImuNoise kNoise{.accel_density = 0.02,
                                .accel_walk = 0.02,
                                .gyro_density = 0.002,
                                .gyro_walk = 0.002,
                                .rate_hz = kRate_hz};

Vector3d normal3(std::mt19937_64& random, double sigma) {
  std::normal_distribution<double> normal;
  return sigma * Vector3d(normal(random), normal(random), normal(random));
}

struct Run {
  std::vector<ImuSample> samples;
  Vector3d bg_end, ba_end;  ///< true biases at the end of the interval
};

/// Samples from 20 ms before the interval to 20 ms after it. White noise of density s has the
/// standard deviation s / sqrt(dt) in a sample; a walk of density s grows by s sqrt(dt). Biases
/// are zero at the interval's start.
Run noisy_run(const pled::support::HandHeldMotion& motion, double start_s, double end_s,
              std::mt19937_64& random) {
  const double dt_s = 1.0 / kRate_hz;
  const int lead = static_cast<int>(std::lround(0.02 * kRate_hz));
  Run run;
  Vector3d bg = Vector3d::Zero();
  Vector3d ba = Vector3d::Zero();
  for (int i = 0;; ++i) {
    const double t_s = i * dt_s;
    if (t_s < start_s - lead * dt_s) continue;
    if (t_s > end_s + lead * dt_s) break;
    ImuSample s = motion.imu(t_s);
    const Vector3d g = bg + normal3(random, kNoise.gyro_density / std::sqrt(dt_s));
    const Vector3d a = ba + normal3(random, kNoise.accel_density / std::sqrt(dt_s));
    for (std::size_t k = 0; k < 3; ++k) {
      s.gyro_radps[k] += g[static_cast<Eigen::Index>(k)];
      s.accel_mps2[k] += a[static_cast<Eigen::Index>(k)];
    }
    run.samples.push_back(s);
    if (t_s >= start_s && t_s < end_s) {
      bg += normal3(random, kNoise.gyro_walk * std::sqrt(dt_s));
      ba += normal3(random, kNoise.accel_walk * std::sqrt(dt_s));
    }
  }
  run.bg_end = bg;
  run.ba_end = ba;
  return run;
}

struct Nees {
  double nine = 0.0, fifteen = 0.0;
};

/// Mean NEES over seeded runs of the increments (9) and of all (15, biases included).
Nees mean_nees(double start_s, double end_s, std::uint64_t seed) {
  const pled::support::HandHeldMotion motion({3.0, 2.6, 3.4});
  std::mt19937_64 random(seed);
  const NavState from = motion.state(start_s);
  std::vector<ImuSample> piece(1024);
  Nees sum;
  for (int run = 0; run < kRuns; ++run) {
    const Run noisy = noisy_run(motion, start_s, end_s, random);
    const auto history = std::make_unique<pled::ImuHistory>();
    for (const ImuSample& s : noisy.samples) REQUIRE(history->add(s));
    NavState to = motion.state(end_s);
    to.bg = noisy.bg_end;
    to.ba = noisy.ba_end;
    bool has_gap = true;
    const std::size_t n = history->interval(from.t, to.t, piece, has_gap);
    REQUIRE(n >= 2);
    REQUIRE_FALSE(has_gap);
    pled::Preintegration p;
    REQUIRE(p.integrate(std::span<const ImuSample>(piece).first(n), Vector3d::Zero(),
                        Vector3d::Zero(), kNoise));
    pled::Vector15d r;
    p.residual(from, to, r, nullptr, nullptr);
    const pled::Vector9d e = r.head<9>();
    const pled::Matrix9d P = p.covariance().topLeftCorner<9, 9>();
    sum.nine += e.dot(P.llt().solve(e));
    sum.fifteen += (p.sqrt_information() * r).squaredNorm();
  }
  return {sum.nine / kRuns, sum.fifteen / kRuns};
}

/// Half of the 95 % range of the mean of kRuns chi-squares of `dof`, as a normal distribution.
double half_range(double dof) { return 1.96 * std::sqrt(2.0 * dof / kRuns); }

}  // namespace

TEST_SUITE("imu.covariance_monte_carlo") {
  TEST_CASE("the mean NEES of 1 s of noisy shaking is the number of degrees of freedom") {
    const Nees n = mean_nees(0.5, 1.5, 31);
    std::printf("1 s, 200 Hz: NEES %.2f of 9 +- %.2f, %.2f of 15 +- %.2f\n", n.nine,
                half_range(9.0), n.fifteen, half_range(15.0));
    CHECK(std::abs(n.nine - 9.0) < half_range(9.0));
    CHECK(std::abs(n.fifteen - 15.0) < half_range(15.0));
  }

  TEST_CASE("so it is for 50 ms whose ends lie between samples, but for the shared ends") {
    // Ten steps. Half of each end sample's weight lies outside the interval: 5 % less variance than
    // the continuous noise has, and a blend of two samples at an end is less noisy than one. The
    // 20 % allowed below are Ours; above there is no reason for any excess.
    const Nees n = mean_nees(0.5021, 0.5521, 32);
    std::printf("50 ms, ends between samples: NEES %.2f of 9 +- %.2f\n", n.nine, half_range(9.0));
    CHECK(n.nine > 0.8 * 9.0 - half_range(9.0));
    CHECK(n.nine < 9.0 + half_range(9.0));
  }
}

TEST_SUITE("imu.truth_check") {
  TEST_CASE(
      "noisy IMU data against exact truth have a mean NEES of one for each degree of freedom") {
    const pled::support::HandHeldMotion motion({3.0, 2.6, 3.4});
    pled::ImuNoise noise = kNoise;
    noise.gyro_walk = 1e-9;
    noise.accel_walk = 1e-9;
    std::mt19937_64 random(33);
    std::vector<ImuSample> imu;
    for (int i = 0; i <= 120'100; ++i) {
      ImuSample s = motion.imu(i / kRate_hz);
      const Vector3d g = normal3(random, noise.gyro_density * std::sqrt(kRate_hz));
      const Vector3d a = normal3(random, noise.accel_density * std::sqrt(kRate_hz));
      for (std::size_t k = 0; k < 3; ++k) {
        s.gyro_radps[k] += g[static_cast<Eigen::Index>(k)];
        s.accel_mps2[k] += a[static_cast<Eigen::Index>(k)];
      }
      imu.push_back(s);
    }
    std::vector<NavState> truth;
    for (int i = 0; i <= 12'000; ++i) truth.push_back(motion.state(0.05 * i));
    const auto c = pled::check_preintegration(truth, imu, 0.5, noise, {});
    CHECK(c.compared == 1200);
    CHECK(c.skipped == 0);
    std::printf("against exact truth: NEES/dof %.3f, p %.3f, theta %.3f, v %.3f\n",
                c.mean_nees_per_dof, c.position_nees_per_dof, c.attitude_nees_per_dof,
                c.velocity_nees_per_dof);
    // 1200 x 9 and 1200 x 3 degrees of freedom: 95 % of the means are within 1.96 sqrt(2 / dof) =
    // 0.027 and 0.046; the ends take 0.5 % away.
    CHECK(std::abs(c.mean_nees_per_dof - 1.0) < 0.032);
    CHECK(std::abs(c.position_nees_per_dof - 1.0) < 0.051);
    CHECK(std::abs(c.attitude_nees_per_dof - 1.0) < 0.051);
    CHECK(std::abs(c.velocity_nees_per_dof - 1.0) < 0.051);
    // Angle error: density sqrt(T) for each of three axes.
    CHECK(c.attitude_rms_rad == doctest::Approx(0.002 * std::sqrt(0.5 * 3.0)).epsilon(0.03));
  }

  TEST_CASE("intervals without samples or with a gap are skipped and counted") {
    const pled::support::HandHeldMotion motion({3.0, 2.6, 3.4});
    std::vector<ImuSample> imu;
    for (int i = 0; i <= 600; ++i) {
      if (i > 200 && i < 300) continue;  // 1.0 s to 1.5 s
      imu.push_back(motion.imu(i / kRate_hz));
    }
    std::vector<NavState> truth;
    for (int i = 0; i <= 40; ++i) truth.push_back(motion.state(0.1 * i));
    const auto c = pled::check_preintegration(truth, imu, 0.5, kNoise, {});
    CHECK(c.compared == 5);  // [0, 1], [1.5, 3]
    CHECK(c.skipped == 3);   // [1, 1.5] and [3, 4]
  }

  TEST_CASE("nothing compared gives NaN, not zero") {
    const auto c = pled::check_preintegration({}, {}, 0.5, kNoise, {});
    CHECK(c.compared == 0);
    CHECK(std::isnan(c.mean_nees_per_dof));
    CHECK(std::isnan(c.attitude_rms_rad));
  }

  TEST_CASE("a standing reference shows its wobble, its bias error and its tilt") {
    constexpr double kTilt_rad = 0.004;
    std::mt19937_64 random(34);
    std::vector<NavState> truth;
    std::vector<ImuSample> imu;
    for (int i = 0; i <= 4000; ++i) {
      NavState s;
      s.t = {i * 10'000};
      s.p_wb = normal3(random, 0.001);
      s.v_wb = normal3(random, 0.003);
      truth.push_back(s);
      imu.push_back({s.t,
                     {0.001, 0.001, 0.001},
                     {9.81 * std::sin(kTilt_rad), 0.0, 9.81 * std::cos(kTilt_rad)}});
    }
    const auto u = pled::measure_standing_truth(truth, imu, 0.5);
    REQUIRE(u.has_value());
    CHECK(u->position_m == doctest::Approx(0.001).epsilon(0.05));
    CHECK(u->velocity_mps == doctest::Approx(0.003).epsilon(0.05));
    CHECK(u->attitude_rad < 1e-12);
    CHECK(u->gyro_bias_radps == doctest::Approx(0.001).epsilon(1e-9));
    CHECK(u->frame_tilt_rad == doctest::Approx(kTilt_rad / std::sqrt(2.0)).epsilon(1e-3));
    CHECK(u->accel_bias_mps2 == doctest::Approx(9.81 * kTilt_rad / std::sqrt(3.0)).epsilon(1e-3));
    CHECK_FALSE(pled::measure_standing_truth(std::span(truth).first(140), imu, 0.5).has_value());
    CHECK_FALSE(pled::measure_standing_truth(truth, {}, 0.5).has_value());
  }
}
