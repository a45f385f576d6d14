// Where no state is known, the cues guess the camera's way from the points and the gyro.
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"
#include "pled_vins/pipeline/temporal_cues.hpp"
#include "support/pipeline/stage_run.hpp"

namespace pled {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kFrame_us = 50'000;
constexpr int kFrames = 6;

/// A rig that turns steadily while its camera, beside the body's origin, goes straight on.
struct TurningRig {
  explicit TurningRig(const Vector3d& gyro_bias_radps) : cues({}, with_lever(), false) {
    for (std::int64_t t = 0; t <= 2'000'000; t += 5000) {
      const Vector3d w = kRate + gyro_bias_radps;
      imu->add({{t}, {w.x(), w.y(), w.z()}, {0, 0, 9.81}});
    }
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (int i = 0; i < 60; ++i) {
      const double z = 4.0 + 2.0 * unit(random);
      points.emplace_back(0.55 * z * unit(random), 0.4 * z * unit(random), z);
    }
    // A pane that sinks, in the picture's left.
    for (int i = 0; i < 6; ++i) points.emplace_back(-2.7 + 0.05 * i, -0.3 + 0.1 * (i % 2), 4.0);
  }

  static RigCalibration with_lever() {
    RigCalibration rig = support::event_rig(false);
    rig.cameras[0].T_body_cam = {so3::exp({0.4, -0.3, 0.9}),
                                 {0.2, 0.2, -0.1}};  // 0.3 m, across the axis
    return rig;
  }
  [[nodiscard]] static bool sinks(std::size_t i) { return i >= 60; }

  /// The camera at frame k, in its place at frame 0 (half way).
  [[nodiscard]] static Pose T_0_cam(int k) {
    const double t_s = 1e-6 * kFrame_us * k;
    const Eigen::Quaterniond R_body_cam = with_lever().cameras[0].T_body_cam.q;
    return {R_body_cam.conjugate() * so3::exp(t_s * kRate) * R_body_cam,
            t_s * Vector3d(0.6, 0.1, 0.2)};
  }

  [[nodiscard]] FrameMeasurement frame(int k) const {
    FrameMeasurement f;
    f.t = Timestamp{1'000'000 + k * kFrame_us};
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3d p = points[i] + Vector3d(0, sinks(i) ? 0.05 * k : 0.0, 0);
      const Eigen::Vector2d at = (T_0_cam(k).inverse() * p).hnormalized();
      PointMeasurement m;
      m.id = static_cast<FeatureId>(i + 1);
      m.track_length = static_cast<std::uint32_t>(k + 1);
      m.bearing_xy = {at.x(), at.y()};
      (void)f.points.push_back(m);
    }
    LineMeasurement line;  // stands at rest among them
    line.id = kFirstImageLineId;
    for (std::size_t e = 0; e < 2; ++e) {
      const Vector3d p(0.5 + 0.2 * static_cast<double>(e), e == 0 ? -0.6 : 0.7, 3.5);
      const Eigen::Vector2d at = (T_0_cam(k).inverse() * p).hnormalized();
      line.bearing_xy[e] = {at.x(), at.y()};
    }
    (void)f.lines.push_back(line);
    return f;
  }

  static inline const Vector3d kRate{0.5, -0.9, 0.7};
  std::unique_ptr<ImuHistory> imu = std::make_unique<ImuHistory>();
  TemporalCues cues;
  std::vector<Vector3d> points;
};

}  // namespace

TEST_SUITE("pipeline.temporal_cues.guess_path") {
  TEST_CASE("a camera beside the body's origin of a rig that turns sees at rest what is at rest") {
    for (const Vector3d& bias :
         {Vector3d(0, 0, 0), Vector3d(0.03, -0.02, 0.025), Vector3d(-0.02, 0.03, 0.03)}) {
      CAPTURE(bias.transpose());
      TurningRig rig(bias);
      std::span<const TemporalWeights> w;
      for (int k = 0; k < kFrames; ++k)
        w = rig.cues.judge(rig.frame(k), *rig.imu, std::nullopt, Vector3d::Zero(), nullptr);
      REQUIRE(w.size() == rig.points.size());
      for (std::size_t i = 0; i < w.size(); ++i) {
        CAPTURE(i);
        if (TurningRig::sinks(i)) {
          CHECK(w[i].motion < 0.3);
        } else if (rig.points[i].x() > -0.4 * rig.points[i].z()) {
          // Away from the pane, which speaks for its neighbours.
          CHECK(w[i].motion > 0.9);
        }
      }
      REQUIRE(rig.cues.lines().size() == 1);
      CHECK(rig.cues.lines()[0].motion > 0.9);
    }
  }
}

}  // namespace pled
