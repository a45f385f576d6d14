#include "src/apps/derived_truth.hpp"

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/sim/point_world.hpp"

namespace pled::apps {
namespace {

/// Poses of a simulated flight every `period_ms`, without velocity and biases.
std::vector<NavState> poses_of(const sim::PointWorld& world, std::int64_t period_ms,
                               double duration_s) {
  std::vector<NavState> out;
  const Timestamp start = Timestamp{} + Duration::from_s(1.0);
  for (Timestamp t = start; (t - start).seconds() <= duration_s;
       t = t + Duration::from_ms(period_ms)) {
    NavState s = world.truth(t);
    s.v_wb = s.bg = s.ba = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    out.push_back(s);
  }
  return out;
}

}  // namespace

TEST_SUITE("apps.derived_truth") {
  TEST_CASE("velocity and biases come out as they were, within the noise that is stated") {
    const sim::PointWorld world({.seed = 3});
    const auto derived = derive_motion(poses_of(world, 5, 9.0), world.imu(), world.rig().imu);
    REQUIRE(derived.has_value());
    const TruthUncertainty& u = derived->uncertainty;
    // density^2 / 1 s + walk^2 1 s / 3.
    CHECK(u.gyro_bias_radps == doctest::Approx(std::hypot(1.7e-4, 2e-5 / std::sqrt(3.0))));
    CHECK(u.accel_bias_mps2 == doctest::Approx(std::hypot(2e-3, 3e-3 / std::sqrt(3.0))));
    CHECK(derived->states.size() > 1500);
    for (const NavState& s : derived->states) {
      const NavState truth = world.truth(s.t);
      // Central differences over 5 ms: h^2 / 6 times a jerk of up to 50 m/s^3.
      REQUIRE((s.v_wb - truth.v_wb).norm() < 2.5e-4);
      REQUIRE((s.bg - truth.bg).cwiseAbs().maxCoeff() < 5.5 * u.gyro_bias_radps);
      REQUIRE((s.ba - truth.ba).cwiseAbs().maxCoeff() < 5.5 * u.accel_bias_mps2);
    }
  }

  TEST_CASE("with exact truth the normalised error of 0.1 s is that of chi squared") {
    double nees = 0.0;
    std::size_t intervals = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const sim::PointWorld world({.seed = seed});
      const auto derived = derive_motion(poses_of(world, 5, 9.0), world.imu(), world.rig().imu);
      REQUIRE(derived.has_value());
      const PreintegrationCheck c = check_preintegration(derived->states, world.imu(), 0.1,
                                                         world.rig().imu, derived->uncertainty);
      nees += c.mean_nees_per_dof * static_cast<double>(c.compared);
      intervals += c.compared;
    }
    REQUIRE(intervals > 400);
    // 4 sigma of chi^2 with 9 degrees of freedom each; a bias is shared by neighbours, which takes
    // some of the independence away.
    const double sigma = std::sqrt(2.0 / (9.0 * static_cast<double>(intervals)));
    CHECK(std::abs(nees / static_cast<double>(intervals) - 1.0) < 4.0 * sigma);
  }

  TEST_CASE("poses that are too few or too far apart are refused") {
    const sim::PointWorld world({.seed = 1, .duration_s = 3.0});
    CHECK_FALSE(derive_motion(poses_of(world, 20, 2.5), world.imu(), world.rig().imu));
    CHECK_FALSE(derive_motion(poses_of(world, 5, 1.0), world.imu(), world.rig().imu));
    CHECK_FALSE(derive_motion({}, world.imu(), world.rig().imu));
    CHECK_FALSE(derive_motion(poses_of(world, 5, 2.5), {}, world.rig().imu));
    CHECK(derive_motion(poses_of(world, 5, 2.5), world.imu(), world.rig().imu));
  }
}

}  // namespace pled::apps
