#include "pled_vins/sim/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"

using namespace pled;
using namespace pled::sim;

TEST_SUITE("sim.trajectory") {
  TEST_CASE("velocity, acceleration and rate are the derivatives of the pose") {
    constexpr double kStep = 1e-4;
    for (const StartKind start : {StartKind::kMoving, StartKind::kStill}) {
      const RoomFlight flight{3, start, 1.0};
      for (double t_s = 0.003; t_s < 6.0; t_s += 0.037) {
        CAPTURE(t_s);
        const Kinematics k = flight.at(t_s);
        const Kinematics a = flight.at(t_s - kStep);
        const Kinematics b = flight.at(t_s + kStep);
        const Eigen::Vector3d v = (b.T_world_body.p - a.T_world_body.p) / (2 * kStep);
        const Eigen::Vector3d acc = (b.v_wb_mps - a.v_wb_mps) / (2 * kStep);
        const Eigen::Vector3d omega =
            so3::log(a.T_world_body.q.conjugate() * b.T_world_body.q) / (2 * kStep);
        CHECK((v - k.v_wb_mps).norm() < 1e-6);
        CHECK((acc - k.a_wb_mps2).norm() < 1e-5);
        CHECK((omega - k.omega_b_radps).norm() < 1e-6);
      }
    }
  }

  TEST_CASE("every seed flies at about 1 m/s, turns below 1 rad/s and stays in mid-room") {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      CAPTURE(seed);
      const RoomFlight flight{seed, StartKind::kMoving, 0.0};
      double sum_mps = 0.0;
      double fastest_radps = 0.0;
      Eigen::Vector3d reach_m = Eigen::Vector3d::Zero();
      constexpr int kSamples = 6000;
      for (int i = 0; i < kSamples; ++i) {
        const Kinematics k = flight.at(i * 0.005);
        sum_mps += k.v_wb_mps.norm();
        fastest_radps = std::max(fastest_radps, k.omega_b_radps.norm());
        const Eigen::Vector3d off = k.T_world_body.p - Eigen::Vector3d{0.0, 0.0, 1.45};
        reach_m = reach_m.cwiseMax(off.cwiseAbs());
      }
      CHECK(sum_mps / kSamples > 0.5);
      CHECK(sum_mps / kSamples < 1.5);
      CHECK(fastest_radps < 1.0);
      CHECK(reach_m.x() < 1.6);
      CHECK(reach_m.y() < 1.8);
      CHECK(reach_m.z() < 0.6);
    }
  }

  TEST_CASE("a still start does not move at all, then flies as a moving one does") {
    const RoomFlight still{5, StartKind::kStill, 2.0};
    const RoomFlight moving{5, StartKind::kMoving, 0.0};
    for (double t_s = -0.1; t_s <= 2.0; t_s += 0.05) {
      const Kinematics k = still.at(t_s);
      CHECK(k.v_wb_mps.norm() == 0.0);
      CHECK(k.omega_b_radps.norm() == 0.0);
      CHECK(k.a_wb_mps2.norm() == 0.0);
    }
    // The ramp of 1.5 s costs half its length.
    const Kinematics a = still.at(5.0), b = moving.at(5.0 - 2.0 - 0.75);
    CHECK((a.T_world_body.p - b.T_world_body.p).norm() < 1e-12);
    CHECK((a.v_wb_mps - b.v_wb_mps).norm() < 1e-12);
  }
}
