#include <cmath>
#include <memory>

#include <doctest/doctest.h>

#include "pled_vins/backend/backend.hpp"
#include "pled_vins/backend/solvers.hpp"
#include "pled_vins/geometry/so3.hpp"
#include "pled_vins/sim/point_world.hpp"

namespace pled {
namespace {

using sim::MotionKind;
using sim::PointWorld;
using sim::PointWorldOptions;

/// What is wrong with what the estimator is told, and what it may mend.
struct Mistake {
  double camera_early_s = 0.0;  ///< frames are stamped so much too early
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  bool mend_time = false;
  bool mend_place = false;
};

struct Found {
  RigState rig;
  double rms_m = 0;  ///< of the positions in the second half, against the truth
  bool tracking = false;
};

Found fly(const Mistake& mistake) {
  PointWorldOptions options;
  options.duration_s = 12.0;
  options.mean_speed_mps = 1.5;
  const PointWorld world(options);
  RigCalibration rig = world.rig();
  Pose& T = rig.cameras[0].T_body_cam;
  T.p += mistake.offset_m;
  T.q = (T.q * so3::exp(mistake.turn_rad)).normalized();
  BackendConfig config;
  config.point_sigma_px = options.pixel_sigma;
  config.estimate_time_shift = mistake.mend_time;
  config.estimate_extrinsic = mistake.mend_place;
  config.time_shift_sigma_s = 0.01;
  config.extrinsic_sigma_m = 0.02;
  config.extrinsic_sigma_rad = 0.03;
  const auto solver = make_solver(SolverKind::kFixed);
  const auto backend = std::make_unique<Backend>(config, rig, *solver);
  const auto imu = std::make_unique<ImuHistory>();
  const auto out = std::make_unique<BackendOutput>();
  std::size_t fed = 0;
  double squares = 0, count = 0;
  for (std::size_t k = 0; k < world.frames().size(); ++k) {
    FrameMeasurement frame = world.frames()[k];
    frame.t = frame.t - Duration::from_s(mistake.camera_early_s);
    while (fed < world.imu().size() && world.imu()[fed].t <= frame.t + Duration::from_ms(20))
      imu->add(world.imu()[fed++]);
    if (k == 0) {
      Vector15d sigma = Vector15d::Constant(0.01);
      sigma.head<3>().setConstant(1e-3);
      sigma.tail<3>().setConstant(0.1);
      backend->start_from(world.truth(frame.t), sigma);
    }
    backend->process(frame, *imu, *out);
    if (2 * k < world.frames().size()) continue;
    const Eigen::Map<const Eigen::Vector3d> p(out->pose.p_world_body_m.data());
    squares += (p - world.truth(frame.t).p_wb).squaredNorm();
    count += 1;
  }
  return {backend->window().rig_state, std::sqrt(squares / count), backend->tracking()};
}

}  // namespace

TEST_SUITE("backend.calibration") {
  TEST_CASE("a time shift of 10 ms is found while flying, and costs accuracy where it may not be") {
    const Found told = fly({});
    const Found bent = fly({.camera_early_s = 0.010});
    const Found mended = fly({.camera_early_s = 0.010, .mend_time = true});
    MESSAGE("position error, m: exact ", told.rms_m, ", 10 ms off ", bent.rms_m, ", refined ",
            mended.rms_m, "; shift found ", 1e3 * mended.rig.time_shift_s, " ms");
    CHECK(mended.tracking);
    // A fifth of the mistake: 12 s of gentle turning tell no more.
    CHECK(std::abs(mended.rig.time_shift_s - 0.010) < 0.002);
    CHECK(mended.rms_m < bent.rms_m);
    const Found sound = fly({.mend_time = true});
    CHECK(std::abs(sound.rig.time_shift_s) < 0.002);
  }

  TEST_CASE("a camera told to be a centimetre and a degree elsewhere is put right while flying") {
    Mistake mistake{.offset_m = {0.006, -0.006, 0.005}, .turn_rad = {0.010, 0.012, -0.008}};
    const Found bent = fly(mistake);
    mistake.mend_place = true;
    const Found mended = fly(mistake);
    const PointWorld world(PointWorldOptions{});
    const Pose truth = world.rig().cameras[0].T_body_cam;
    const double turn_rad = mended.rig.T_body_cam.q.angularDistance(truth.q);
    const double offset_m = (mended.rig.T_body_cam.p - truth.p).norm();
    MESSAGE("position error, m: bent ", bent.rms_m, ", refined ", mended.rms_m,
            "; left: ", 1e3 * turn_rad, " mrad of 17.5, ", 1e3 * offset_m, " mm of 9.8");
    CHECK(mended.tracking);
    CHECK(turn_rad < 0.004);
    CHECK(offset_m < 0.007);
    CHECK(mended.rms_m < bent.rms_m);
  }
}

}  // namespace pled
