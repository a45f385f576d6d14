#include "pled_vins/backend/feature_noise.hpp"

#include <cmath>
#include <memory>
#include <random>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <doctest/doctest.h>

#include "pled_vins/backend/factors.hpp"

namespace pled {
namespace {

constexpr std::uint8_t kFrameCamera = 0;
constexpr std::uint8_t kEventCamera = 1;

RigCalibration two_camera_rig() {
  RigCalibration rig;
  rig.num_cameras = 2;
  rig.frame_camera = kFrameCamera;
  rig.event_camera = kEventCamera;
  rig.cameras[0].fx_px = rig.cameras[0].fy_px = 200.0;
  rig.cameras[1].fx_px = rig.cameras[1].fy_px = 300.0;
  return rig;
}

/// A window of eight states side by side whose poses are exact, and points fitted to their noisy
/// sightings as a solve would leave them.
class NoisyWindow {
 public:
  NoisyWindow() : window_(std::make_unique<SlidingWindow>()) {
    for (int k = 0; k < kStates; ++k)
      window_->push_state()->x.p_wb = Eigen::Vector3d(0.15 * k, 0.05 * (k % 3), 0.02 * k);
  }

  void add_points(FeatureKind kind, double sigma_px, int count) {
    const std::uint8_t camera = kind == FeatureKind::kEventPoint ? kEventCamera : kFrameCamera;
    std::normal_distribution<double> noise(0.0, sigma_px / mean_focal_px(rig_.cameras[camera]));
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d p_w(0.5 + 1.5 * unit(random_), unit(random_), 3.0 + unit(random_));
      Landmark l;
      l.in_solver = l.has_depth = true;
      for (std::uint8_t k = 0; k < kStates; ++k) {
        const Eigen::Vector2d at = (p_w - window_->state(k).x.p_wb).hnormalized();
        Observation seen;
        seen.state = k;
        seen.camera = camera;
        seen.kind = kind;
        seen.xy = {at.x() + noise(random_), at.y() + noise(random_)};
        REQUIRE(l.observations.push_back(seen));
      }
      l.bearing_depth = {l.observations[0].xy[0], l.observations[0].xy[1], 1.0 / p_w.z()};
      fit(l);
      REQUIRE(window_->landmarks.push_back(l));
    }
  }

  /// What is measured after many frames, weighed with `weights_px` meanwhile.
  [[nodiscard]] FeatureSigmas measure(FeatureNoise& noise, const FeatureSigmas& weights_px) const {
    FactorSettings settings = make_factor_settings({}, rig_);
    set_feature_noise(settings, rig_, weights_px);
    for (int k = 0; k < 100; ++k) noise.observe(*window_, rig_, settings);
    return noise.sigmas_px();
  }
  [[nodiscard]] SlidingWindow& window() { return *window_; }

 private:
  static constexpr int kStates = 8;

  /// Least squares over the point's three figures.
  void fit(Landmark& l) const {
    const FactorSettings settings = make_factor_settings({}, rig_);
    for (int step = 0; step < 8; ++step) {
      Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
      Eigen::Vector3d g = Eigen::Vector3d::Zero();
      for (const Observation& seen : l.observations) {
        Eigen::Vector2d r;
        PointJacobians J;
        REQUIRE(evaluate_point(*window_, rig_, settings, l, seen, r, &J));
        H += J.point.transpose() * J.point;
        g += J.point.transpose() * r;
      }
      const Eigen::Vector3d d = H.ldlt().solve(g);
      for (std::size_t k = 0; k < 3; ++k) l.bearing_depth[k] -= d[static_cast<Eigen::Index>(k)];
    }
  }

  RigCalibration rig_ = two_camera_rig();
  std::unique_ptr<SlidingWindow> window_;
  std::mt19937_64 random_{4};
};

}  // namespace

TEST_SUITE("backend.point_noise") {
  TEST_CASE("each kind of point is weighed by its own noise and its camera's focal length") {
    const RigCalibration rig = two_camera_rig();
    BackendConfig config;
    config.point_sigma_px = 0.25;
    config.event_point_sigma_px = 0.5;
    FactorSettings settings = make_factor_settings(config, rig);
    CHECK(settings.weight_of(FeatureKind::kImagePoint, kFrameCamera) == doctest::Approx(800));
    CHECK(settings.weight_of(FeatureKind::kImagePoint, kEventCamera) == doctest::Approx(1200));
    CHECK(settings.weight_of(FeatureKind::kEventPoint, kFrameCamera) == doctest::Approx(400));
    CHECK(settings.weight_of(FeatureKind::kEventPoint, kEventCamera) == doctest::Approx(600));
    set_feature_noise(settings, rig, {2.0, 0.1});
    CHECK(settings.weight_of(FeatureKind::kImagePoint, kFrameCamera) == doctest::Approx(100));
    CHECK(settings.weight_of(FeatureKind::kEventPoint, kEventCamera) == doctest::Approx(3000));
  }

  TEST_CASE("the noise of each kind is measured as it is, whatever the other's and the weights") {
    for (const FeatureSigmas& truth : {FeatureSigmas{0.3, 0.9}, FeatureSigmas{0.8, 0.2}}) {
      NoisyWindow f;
      f.add_points(FeatureKind::kImagePoint, truth[0], 200);
      f.add_points(FeatureKind::kEventPoint, truth[1], 150);
      for (const FeatureSigmas& weights : {FeatureSigmas{0.5, 0.5}, FeatureSigmas{0.1, 3.0}}) {
        FeatureNoise noise({0.1, 0.1});
        const FeatureSigmas found = f.measure(noise, weights);
        // The median of 150 chi-square values of 13 degrees of freedom is known to 2 %.
        CHECK(found[0] == doctest::Approx(truth[0]).epsilon(0.06));
        CHECK(found[1] == doctest::Approx(truth[1]).epsilon(0.06));
      }
    }
  }

  TEST_CASE("a third of the points that move do not change what is measured much") {
    NoisyWindow f;
    f.add_points(FeatureKind::kEventPoint, 0.5, 100);
    f.add_points(FeatureKind::kEventPoint, 20.0, 50);
    FeatureNoise noise({0.1, 0.1});
    CHECK(f.measure(noise, {1.0, 1.0})[1] < 0.65);
  }

  TEST_CASE("too few points of a kind leave its noise as it was") {
    NoisyWindow f;
    f.add_points(FeatureKind::kImagePoint, 0.6, 40);
    f.add_points(FeatureKind::kEventPoint, 0.6, 9);
    FeatureNoise noise({0.2, 0.25});
    FeatureSigmas found = f.measure(noise, {0.3, 0.3});
    CHECK(found[0] > 0.45);
    CHECK(found[1] == 0.25);
    f.add_points(FeatureKind::kEventPoint, 0.6, 1);
    found = f.measure(noise, {0.3, 0.3});
    CHECK(found[1] > 0.3);
    for (Landmark& l : f.window().landmarks) l.in_solver = false;  // none took part
    noise.reset();
    CHECK(f.measure(noise, {0.3, 0.3}) == FeatureSigmas{0.2, 0.25});
  }

  TEST_CASE("it stays within its least and ten times that, and follows within a second") {
    NoisyWindow f;
    f.add_points(FeatureKind::kImagePoint, 0.05, 50);
    f.add_points(FeatureKind::kEventPoint, 5.0, 50);
    FeatureNoise noise({0.2, 0.3});
    const FeatureSigmas found = f.measure(noise, {0.5, 0.5});
    CHECK(found[0] == 0.2);
    CHECK(found[1] == doctest::Approx(3.0));

    FeatureNoise fresh({0.5, 0.5});
    FactorSettings settings = make_factor_settings({}, two_camera_rig());
    fresh.observe(f.window(), two_camera_rig(), settings);
    CHECK(fresh.sigmas_px()[1] < 1.2);  // a tenth of the way
    fresh.reset();
    CHECK(fresh.sigmas_px() == FeatureSigmas{0.5, 0.5});
  }
}

}  // namespace pled
