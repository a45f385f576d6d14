#include "pled_vins/imu/dead_reckoning.hpp"

#include <array>
#include <cmath>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"

namespace {

using namespace pled;

constexpr double kGravity = 9.81;

/// A body that turns at a constant rate and is pushed along the world's x: what its sensors read
/// and where it is, in closed form.
struct Ride {
  Eigen::Vector3d rate{0.3, -0.5, 1.1};
  Eigen::Vector3d bg{0.01, -0.02, 0.03};
  Eigen::Vector3d ba{0.1, 0.05, -0.2};
  double push_mps2 = 2.0;
  double speed_mps = -1.0;

  [[nodiscard]] NavState at(Timestamp t) const {
    const double s = t.seconds();
    NavState x;
    x.t = t;
    x.q_wb = so3::exp(rate * s);
    x.p_wb = {1.0 + speed_mps * s + 0.5 * push_mps2 * s * s, 0.0, 0.5};
    x.v_wb = {speed_mps + push_mps2 * s, 0.0, 0.0};
    x.bg = bg;
    x.ba = ba;
    return x;
  }
  [[nodiscard]] ImuSample sample(Timestamp t) const {
    const Eigen::Quaterniond q = at(t).q_wb;
    const Eigen::Vector3d force = q.conjugate() * Eigen::Vector3d(push_mps2, 0.0, kGravity) + ba;
    const Eigen::Vector3d gyro = rate + bg;
    return {t, {gyro.x(), gyro.y(), gyro.z()}, {force.x(), force.y(), force.z()}};
  }
};

struct History {
  Ride ride;
  ImuHistory imu;
  explicit History(std::int64_t hole_from_us = -1, std::int64_t hole_to_us = -1) {
    for (std::int64_t us = 0; us <= 1'000'000; us += 5000)
      if (us < hole_from_us || us > hole_to_us) (void)imu.add(ride.sample({us}));
  }
};

}  // namespace

TEST_SUITE("imu.dead_reckoning") {
  TEST_CASE("the path to both sides of a known state is that of the motion") {
    const History h;
    const NavState known = h.ride.at({501'234});
    const std::array<Timestamp, 5> times{Timestamp{552'000}, Timestamp{501'234}, Timestamp{460'000},
                                         Timestamp{402'500}, Timestamp{201'000}};
    std::array<Pose, 5> path;
    for (Pose& pose : path) pose.p.setConstant(std::nan(""));
    REQUIRE(dead_reckon(h.imu, known, kGravity, times, path) == times.size());
    for (std::size_t k = 0; k < times.size(); ++k) {
      CAPTURE(k);
      const NavState truth = h.ride.at(times[k]);
      // Half a trapezoid's error: rate^2 * force * dt^2 / 12 in acceleration, integrated twice.
      CHECK((path[k].p - truth.p_wb).norm() < 5e-5);
      CHECK(path[k].q.angularDistance(truth.q_wb) < 1e-9);
    }
  }

  TEST_CASE("times on one side alone, in either order of distance, are reached") {
    const History h;
    const NavState known = h.ride.at({500'000});
    std::array<Pose, 2> path;
    REQUIRE(dead_reckon(h.imu, known, kGravity, std::array{Timestamp{700'000}, Timestamp{600'000}},
                        path) == 2);
    CHECK((path[0].p - h.ride.at({700'000}).p_wb).norm() < 5e-5);
    CHECK((path[1].p - h.ride.at({600'000}).p_wb).norm() < 5e-5);
    REQUIRE(dead_reckon(h.imu, known, kGravity, std::array{Timestamp{400'000}, Timestamp{300'000}},
                        path) == 2);
    CHECK((path[0].p - h.ride.at({400'000}).p_wb).norm() < 5e-5);
    CHECK((path[1].p - h.ride.at({300'000}).p_wb).norm() < 5e-5);
  }

  TEST_CASE("a hole in the data, or time without data, gives no path") {
    const History h(300'000, 400'000);
    const NavState known = h.ride.at({500'000});
    const auto reached = [&](auto... t_us) {
      std::array<Pose, sizeof...(t_us)> path;
      const std::array times{Timestamp{t_us}...};
      return dead_reckon(h.imu, known, kGravity, times, path);
    };
    CHECK(reached(420'000) == 1);
    CHECK(reached(250'000) == 0);
    CHECK(reached(1'200'000) == 0);
    CHECK(reached(1'200'000, 450'000) == 0);  // the newest is missing: nothing can be told
    CHECK(reached(550'000, 450'000, 420'000, 250'000, 240'000) == 3);
  }
}
