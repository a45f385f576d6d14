#include "pled_vins/sim/imu_model.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"
#include "pled_vins/imu/preintegration.hpp"
#include "src/sim/spline_trajectory.hpp"
#include "tests/support/room_flight.hpp"

using namespace pled;
using namespace pled::sim;

namespace {

/// Stands still and level: what the sensor adds is all there is.
class AtRest final : public Trajectory {
 public:
  Kinematics at(double) const noexcept override { return {}; }
};

NavState state_at(const Trajectory& trajectory, Timestamp t) {
  const Kinematics k = trajectory.at(t.seconds());
  NavState s;
  s.t = t;
  s.p_wb = k.T_world_body.p;
  s.q_wb = k.T_world_body.q;
  s.v_wb = k.v_wb_mps;
  return s;
}

/// A preset's flight, or a spline through the poses of one at 100 Hz.
std::unique_ptr<Trajectory> flight_named(std::string_view name) {
  if (const auto options = preset(name)) return std::make_unique<SineFlight>(*options);
  const SineFlight room(*preset("room"));
  std::vector<SplineTrajectory::Sample> samples;
  for (int k = 0; k <= 3000; ++k) samples.push_back({0.01 * k, room.at(0.01 * k).T_world_body});
  return std::make_unique<SplineTrajectory>(samples);
}

}  // namespace

TEST_SUITE("sim.imu_model") {
  TEST_CASE("readings without noise integrate to the true pose: 30 s to a centimetre") {
    ImuOptions options;
    options.with_noise = false;
    for (const std::string_view name : {"room", "hand", "car_park", "street", "recorded path"}) {
      CAPTURE(name);
      const std::unique_ptr<Trajectory> made = flight_named(name);
      const Trajectory& flight = *made;
      REQUIRE(flight.longest_s() >= 30.0);
      const std::vector<ImuSample> samples = simulate_imu(flight, 30.0, options, 1).samples;
      REQUIRE(samples.size() == 6001);
      NavState state = state_at(flight, samples.front().t);
      constexpr std::size_t kPart = 100;
      for (std::size_t i = 0; i + kPart < samples.size(); i += kPart) {
        Preintegration part;
        REQUIRE(part.integrate(std::span(samples).subspan(i, kPart + 1), Eigen::Vector3d::Zero(),
                               Eigen::Vector3d::Zero(), options.noise));
        state = part.predict(state);
      }
      const NavState truth = state_at(flight, samples.back().t);
      MESSAGE(std::string(name),
              ": position error after 30 s, mm: ", 1e3 * (state.p_wb - truth.p_wb).norm());
      CHECK((state.p_wb - truth.p_wb).norm() < 1e-2);
      CHECK((state.v_wb - truth.v_wb).norm() < 2e-3);
      CHECK(so3::log(state.q_wb.conjugate() * truth.q_wb).norm() < 2e-4);
    }
  }

  TEST_CASE("at rest the noise has the configured density, the walk and the bias theirs") {
    ImuOptions options;
    options.noise = {.accel_density = 0.002,
                     .accel_walk = 0.0,
                     .gyro_density = 0.0002,
                     .gyro_walk = 0.0,
                     .rate_hz = 200.0};
    const std::vector<ImuSample> samples = simulate_imu(AtRest{}, 100.0, options, 4).samples;
    const auto n = static_cast<double>(samples.size());
    Eigen::Vector3d mean_gyro = Eigen::Vector3d::Zero(), mean_accel = Eigen::Vector3d::Zero();
    for (const ImuSample& s : samples) {
      mean_gyro += Eigen::Vector3d{s.gyro_radps.data()} / n;
      mean_accel += Eigen::Vector3d{s.accel_mps2.data()} / n;
    }
    double gyro2 = 0.0, accel2 = 0.0;
    for (const ImuSample& s : samples) {
      gyro2 += (Eigen::Vector3d{s.gyro_radps.data()} - mean_gyro).squaredNorm() / (3.0 * n);
      accel2 += (Eigen::Vector3d{s.accel_mps2.data()} - mean_accel).squaredNorm() / (3.0 * n);
    }
    // 60,000 values: the deviation is known to 0.3 %.
    CHECK(std::sqrt(gyro2) == doctest::Approx(0.0002 * std::sqrt(200.0)).epsilon(0.015));
    CHECK(std::sqrt(accel2) == doctest::Approx(0.002 * std::sqrt(200.0)).epsilon(0.015));
    CHECK(mean_gyro.norm() == doctest::Approx(0.01).epsilon(0.02));
    CHECK((mean_accel - Eigen::Vector3d{0, 0, 9.81}).norm() == doctest::Approx(0.05).epsilon(0.03));
  }

  TEST_CASE("a bias walk spreads with the square root of time") {
    ImuOptions options;
    options.noise = {.accel_density = 0.0,
                     .accel_walk = 0.003,
                     .gyro_density = 0.0,
                     .gyro_walk = 0.00002,
                     .rate_hz = 200.0};
    options.gyro_bias_radps = 0.0;
    options.accel_bias_mps2 = 0.0;
    double gyro2 = 0.0, accel2 = 0.0;
    constexpr int kRuns = 400;
    for (int run = 0; run < kRuns; ++run) {
      const std::vector<ImuSample> s =
          simulate_imu(AtRest{}, 4.0, options, static_cast<std::uint64_t>(run)).samples;
      gyro2 += Eigen::Vector3d{s.back().gyro_radps.data()}.squaredNorm() / (3.0 * kRuns);
      accel2 += (Eigen::Vector3d{s.back().accel_mps2.data()} - Eigen::Vector3d{0, 0, 9.81})
                    .squaredNorm() /
                (3.0 * kRuns);
    }
    CHECK(std::sqrt(gyro2) == doctest::Approx(0.00002 * 2.0).epsilon(0.08));
    CHECK(std::sqrt(accel2) == doctest::Approx(0.003 * 2.0).epsilon(0.08));
  }
}
