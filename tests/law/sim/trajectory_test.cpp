#include "pled_vins/sim/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <unistd.h>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"
#include "src/sim/spline_trajectory.hpp"
#include "tests/support/room_flight.hpp"

using namespace pled;
using namespace pled::sim;

namespace {

/// The flight as a tracking system would have recorded it, 100 poses a second.
std::vector<SplineTrajectory::Sample> recorded(const Trajectory& flight, double duration_s) {
  std::vector<SplineTrajectory::Sample> samples;
  for (int i = 0; i <= static_cast<int>(100 * duration_s); ++i)
    samples.push_back({0.01 * i, flight.at(0.01 * i).T_world_body});
  return samples;
}

}  // namespace

TEST_SUITE("sim.trajectory") {
  TEST_CASE("velocity, acceleration and rate are the derivatives of the pose") {
    constexpr double kStep = 1e-4;
    std::vector<std::unique_ptr<Trajectory>> all;
    for (const std::string_view name : kPresetNames) {
      const SimulationOptions options = *preset(name);
      all.push_back(std::make_unique<SineFlight>(options));
    }
    all.push_back(std::make_unique<SplineTrajectory>(recorded(*all.front(), 6.5)));
    for (const auto& flight : all) {
      for (double t_s = 0.003; t_s < 6.0; t_s += 0.037) {
        CAPTURE(t_s);
        const Kinematics k = flight->at(t_s);
        const Kinematics a = flight->at(t_s - kStep);
        const Kinematics b = flight->at(t_s + kStep);
        const Eigen::Vector3d v = (b.T_world_body.p - a.T_world_body.p) / (2 * kStep);
        const Eigen::Vector3d acc = (b.v_wb_mps - a.v_wb_mps) / (2 * kStep);
        const Eigen::Vector3d omega =
            so3::log(a.T_world_body.q.conjugate() * b.T_world_body.q) / (2 * kStep);
        CHECK((v - k.v_wb_mps).norm() < 1e-5);
        CHECK((acc - k.a_wb_mps2).norm() < 1e-3);  // a spline's third derivative has steps
        CHECK((omega - k.omega_b_radps).norm() < 1e-5);
      }
    }
  }

  TEST_CASE("every seed flies at about 1 m/s, turns below 1 rad/s and stays in mid-room") {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      CAPTURE(seed);
      const SineFlight flight = room_flight(seed, StartKind::kMoving, 0.0);
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
    const SineFlight still = room_flight(5, StartKind::kStill, 2.0);
    const SineFlight moving = room_flight(5, StartKind::kMoving, 0.0);
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

  TEST_CASE("a hand turns up to 4 rad/s and no faster, a car heads where it drives") {
    double fastest_radps = 0.0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      SimulationOptions options = *preset("hand");
      options.seed = seed;
      const SineFlight hand(options);
      double fastest_of_seed_radps = 0.0;
      for (int i = 0; i < 2000; ++i)  // its 10 s
        fastest_of_seed_radps =
            std::max(fastest_of_seed_radps, hand.at(i * 0.005).omega_b_radps.norm());
      CHECK(fastest_of_seed_radps > 2.5);
      fastest_radps = std::max(fastest_radps, fastest_of_seed_radps);
    }
    MESSAGE("fastest turn of the hand: ", fastest_radps, " rad/s");
    CHECK(fastest_radps > 3.6);
    CHECK(fastest_radps < 4.2);
    const SineFlight car(*preset("street"));
    for (double t_s = 0.0; t_s < 20.0; t_s += 0.1) {
      const Kinematics k = car.at(t_s);
      CHECK(k.v_wb_mps.x() > 1.0);
      const Eigen::Vector3d ahead = k.T_world_body.q * Eigen::Vector3d::UnitZ();
      CHECK(ahead.cross(k.v_wb_mps.normalized()).norm() < 0.08);
    }
  }

  TEST_CASE("a spline keeps to the path that it was fitted to, and stands before and after") {
    const SineFlight flight(*preset("room"));
    const SplineTrajectory spline(recorded(flight, 8.0));
    CHECK(spline.longest_s() == doctest::Approx(8.0));
    for (double t_s = 0.2; t_s < 7.8; t_s += 0.03) {
      const Pose truth = flight.at(t_s).T_world_body;
      CHECK((spline.at(t_s).T_world_body.p - truth.p).norm() < 2e-3);
      CHECK(spline.at(t_s).T_world_body.q.angularDistance(truth.q) < 3e-3);
    }
    CHECK(spline.at(-1.0).v_wb_mps.norm() == 0.0);
    CHECK(spline.at(9.0).omega_b_radps.norm() == 0.0);
    CHECK((spline.at(9.0).T_world_body.p - spline.at(8.0).T_world_body.p).norm() < 1e-9);
  }

  TEST_CASE("a path file is followed, and one that is none is refused for its reason") {
    namespace fs = std::filesystem;
    const fs::path file =
        fs::temp_directory_path() / ("pled_path_" + std::to_string(getpid()) + ".tum");
    const auto error_of = [&](const std::string& text) {
      std::ofstream(file) << text;
      return read_spline_trajectory(file).error();
    };
    const auto code_of = [&](const std::string& text) { return error_of(text).code; };
    CHECK(read_spline_trajectory(file).error().code == ErrorCode::kNotFound);
    CHECK(code_of("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n") == ErrorCode::kUnsupported);
    CHECK(code_of("0 0 0 0 0 0 0 1\n1 0 0 zero 0 0 0 1\n") == ErrorCode::kCorrupt);
    CHECK(error_of("# t\n0 0 0 0 0 0 0 1\n1 0 0 zero 0 0 0 1\n").detail == 3);
    CHECK(code_of("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n") == ErrorCode::kCorrupt);
    CHECK(code_of("0 0 0 0 0 0 0 0\n") == ErrorCode::kCorrupt);
    std::string text = "# t x y z q\n";
    for (int i = 0; i <= 40; ++i)  // 2 m along x in 4 s, from a place far away
      text +=
          std::to_string(1000.0 + 0.1 * i) + " " + std::to_string(70 + 0.05 * i) + " 5 9 0 0 0 1\n";
    std::ofstream(file) << text;
    const auto read = read_spline_trajectory(file);
    REQUIRE(read.ok());
    const Kinematics k = read.value()->at(2.0);
    CHECK((k.T_world_body.p - Eigen::Vector3d(0, 0, 1.45)).norm() < 1e-3);
    CHECK((k.v_wb_mps - Eigen::Vector3d(0.5, 0, 0)).norm() < 1e-3);
    fs::remove(file);
  }
}
