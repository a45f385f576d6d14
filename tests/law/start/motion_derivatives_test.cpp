#include <memory>

#include <doctest/doctest.h>

#include "src/backend/start/imu_path.hpp"
#include "src/backend/start/refine.hpp"
#include "tests/support/start_world.hpp"

using namespace pled;
using namespace pled::support;
using namespace pled::start;

namespace {

struct Scene {
  Scene() {
    PointWorldOptions options;
    options.motion = MotionKind::kHandheld;
    options.duration_s = 2;
    world = std::make_unique<PointWorld>(options);
    frames = start_frames(*world, 3, 0.8);
    fill_history(*world, frames.back().t, imu);
    x.v_0 = {0.4, -1.1, 0.3};
    x.g_0 = {1.0, -2.0, -9.5};
    x.bg = {0.01, 0.02, -0.03};
    x.ba = {0.1, -0.05, 0.02};
  }
  /// Residual of one point from frame 2 in frame `k` at a motion, everything integrated anew.
  Eigen::Vector2d residual(const MotionState& at, std::size_t k, const StartPoint& landmark) {
    REQUIRE(path.integrate(frames, imu, at.bg, at.ba) == StartRefusal::kNone);
    const Pose& T_bc = world->rig().cameras[0].T_body_cam;
    Reprojection p;
    REQUIRE(reproject(view(at, path[2], T_bc), view(at, path[k], T_bc), landmark, seen, p));
    return p.r;
  }

  std::unique_ptr<PointWorld> world;
  StartFrames frames;
  ImuHistory imu;
  ImuPath path;
  MotionState x;
  StartPoint point{{0.1, -0.2, 0.25}};
  Eigen::Vector2d seen{0.05, 0.02};
};

}  // namespace

TEST_SUITE("start.motion_derivatives") {
  TEST_CASE("derivatives of a reprojection by the motion equal central differences") {
    const auto scene = std::make_unique<Scene>();
    Scene& s = *scene;
    const Pose& T_bc = s.world->rig().cameras[0].T_body_cam;
    for (const std::size_t k : {std::size_t{0}, std::size_t{9}, s.frames.size() - 1}) {
      REQUIRE(s.path.integrate(s.frames, s.imu, s.x.bg, s.x.ba) == StartRefusal::kNone);
      const CameraView anchor = view(s.x, s.path[2], T_bc);
      const CameraView at = view(s.x, s.path[k], T_bc);
      Reprojection p;
      REQUIRE(reproject(anchor, at, s.point, s.seen, p));
      const Eigen::Matrix<double, 2, kMotionSize> J = d_motion(anchor, at, s.point, p);
      for (int i = 0; i < kMotionSize; ++i) {
        MotionVector d = MotionVector::Zero();
        d[i] = 1e-5;
        const Eigen::Vector2d numeric =
            (s.residual(box_plus(s.x, d), k, s.point) - s.residual(box_plus(s.x, -d), k, s.point)) /
            2e-5;
        CAPTURE(k);
        CAPTURE(i);
        CHECK((J.col(i) - numeric).norm() < 1e-6 * (1 + numeric.norm()));
      }
    }
  }

  TEST_CASE("derivatives of a reprojection by the point equal central differences") {
    const auto scene = std::make_unique<Scene>();
    Scene& s = *scene;
    const Pose& T_bc = s.world->rig().cameras[0].T_body_cam;
    REQUIRE(s.path.integrate(s.frames, s.imu, s.x.bg, s.x.ba) == StartRefusal::kNone);
    Reprojection p;
    REQUIRE(reproject(view(s.x, s.path[2], T_bc), view(s.x, s.path[9], T_bc), s.point, s.seen, p));
    for (int i = 0; i < 3; ++i) {
      StartPoint plus = s.point;
      StartPoint minus = s.point;
      plus.xy_rho[i] += 1e-6;
      minus.xy_rho[i] -= 1e-6;
      const Eigen::Vector2d numeric = (s.residual(s.x, 9, plus) - s.residual(s.x, 9, minus)) / 2e-6;
      CHECK((p.d_point.col(i) - numeric).norm() < 1e-7 * (1 + numeric.norm()));
    }
  }

  TEST_CASE("the integrated path is the true one to a millimetre over a second") {
    PointWorldOptions options;
    options.motion = MotionKind::kHandheld;
    options.duration_s = 2;
    options.exact_imu = true;
    const PointWorld world(options);
    const StartFrames frames = start_frames(world, 0, 1.0);
    const auto imu = std::make_unique<ImuHistory>();
    fill_history(world, frames.back().t, *imu);
    const auto path = std::make_unique<ImuPath>();
    REQUIRE(path->integrate(frames, *imu, options.gyro_bias_radps, options.accel_bias_mps2) ==
            StartRefusal::kNone);
    const NavState first = world.truth(frames.front().t);
    const Eigen::Matrix3d R_0w = first.q_wb.conjugate().toRotationMatrix();
    for (std::size_t k = 0; k < frames.size(); ++k) {
      const NavState truth = world.truth(frames[k].t);
      const PathPoint& p = (*path)[k];
      const Eigen::Vector3d moved = R_0w * (truth.p_wb - first.p_wb - first.v_wb * p.t_s -
                                            0.5 * p.t_s * p.t_s * kGravityWorld);
      CHECK((p.alpha - moved).norm() < 1e-3);
      CHECK((p.R_0k - R_0w * truth.q_wb.toRotationMatrix()).norm() < 1e-3);
    }
  }
}
