#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include "support/frontend/tracked_scene.hpp"

namespace pled {
namespace {

using support::pose_at;

constexpr double kOnePixelAtOneMetre = 1.0 / 199.0;

/// A tracker that is offered corners, in front of a textured plane.
class OfferedScene {
 public:
  explicit OfferedScene(FeatureKind kind, const FrontendConfig& config = {})
      : camera_(support::davis240_camera(false)),
        scene_(camera_, support::Texture(1, 0.04, 0.5)),
        storage_(std::make_unique<support::Storage240>()),
        tracker_(config, camera_, bare(storage_->view(), kind), {1, kind}) {}

  void show(const Pose& T_world_cam, bool negative, std::span<const Corner> offered) {
    support::GreyImage image = scene_.render(T_world_cam, 180, 30, 0, random_);
    if (negative)
      for (std::uint8_t& grey : image.pixels) grey = static_cast<std::uint8_t>(255 - grey);
    FrameView frame;
    frame.t = Timestamp{++frames_ * 50'000};
    frame.image = image.view();
    REQUIRE(tracker_.track(frame, frame.t, Eigen::Quaterniond::Identity(), offered, measured_));
  }
  [[nodiscard]] const auto& points() const { return measured_.points; }
  [[nodiscard]] std::uint32_t lost() const { return measured_.lost; }
  [[nodiscard]] FrameTracker& tracker() { return tracker_; }

 private:
  /// What finding corners needs is not there for event points.
  static FrameTrackerBuffers bare(FrameTrackerBuffers buffers, FeatureKind kind) {
    if (kind != FeatureKind::kEventPoint) return buffers;
    buffers.corner_rows = {};
    buffers.response = {};
    buffers.mask = {};
    buffers.corner_cells = {};
    return buffers;
  }

  Camera camera_;
  support::PlaneScene scene_;
  std::unique_ptr<support::Storage240> storage_;
  FrameTracker tracker_;
  FrameMeasurement measured_;
  std::mt19937_64 random_{7};
  std::int64_t frames_ = 0;
};

std::vector<Corner> grid_of_corners(int step_px, int offset_px = 0) {
  std::vector<Corner> corners;
  for (int y = 10 + offset_px; y < 170; y += step_px)
    for (int x = 10 + offset_px; x < 230; x += step_px)
      corners.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), 1.0F});
  return corners;
}

}  // namespace

TEST_SUITE("frontend.frame_tracker.offered") {
  TEST_CASE("offered corners keep their distance, from tracks too, the first ones first") {
    FrontendConfig config;
    config.min_distance_px = 12;
    OfferedScene scene(FeatureKind::kEventPoint, config);
    std::vector<Corner> offered = grid_of_corners(7);
    offered.insert(offered.begin(), {{3, 90, 1.0F}, {100, 100, 1.0F}, {105, 100, 1.0F}});
    scene.show(pose_at(0, 0, -1), false, offered);
    const auto first = scene.points();
    REQUIRE(first.size() > 30);
    CHECK(first[0].raw_px == std::array{100.0, 100.0});  // the one before lies on the border
    // On the same picture tracks stay where they are; what is new keeps away from them.
    scene.show(pose_at(0, 0, -1), false, grid_of_corners(7, 3));
    const auto& points = scene.points();
    REQUIRE(points.size() > first.size() / 2);
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t k = 0; k < i; ++k)
        CHECK(std::hypot(points[i].raw_px[0] - points[k].raw_px[0],
                         points[i].raw_px[1] - points[k].raw_px[1]) >= 11.9);
  }

  TEST_CASE("no more are taken than wanted") {
    FrontendConfig config;
    config.max_points = 20;
    OfferedScene scene(FeatureKind::kEventPoint, config);
    for (int k = 0; k < 3; ++k) {
      scene.show(pose_at(0.02 * k, 0, -1), false, grid_of_corners(11, k));
      CHECK(scene.points().size() <= 20);
    }
    CHECK(scene.points().size() == 20);
  }

  TEST_CASE("event points have their kind, their camera and ids that no image point has") {
    OfferedScene scene(FeatureKind::kEventPoint);
    OfferedScene image(FeatureKind::kImagePoint);
    std::set<FeatureId> ids;
    for (int k = 0; k < 3; ++k) {
      scene.show(pose_at(0, 0, -1), false, grid_of_corners(15));
      for (const PointMeasurement& p : scene.points()) {
        CHECK(p.kind == FeatureKind::kEventPoint);
        CHECK(p.camera == 1);
        CHECK(p.id >= kFirstEventPointId);
        CHECK((p.track_length > 1 || ids.insert(p.id).second));  // none is given twice
      }
      scene.tracker().reset();
    }
    REQUIRE(!ids.empty());
    CHECK(*ids.begin() == kFirstEventPointId);
    image.show(pose_at(0, 0, -1), false, grid_of_corners(15));
    for (const PointMeasurement& p : image.points()) {
      CHECK(p.kind == FeatureKind::kImagePoint);
      CHECK(p.id < kFirstEventPointId);
    }
  }

  TEST_CASE("nothing offered, nothing begun") {
    OfferedScene scene(FeatureKind::kEventPoint);
    scene.show(pose_at(0, 0, -1), false, {});
    CHECK(scene.points().size() == 0);
    scene.show(pose_at(0, 0, -1), false, {});
    CHECK(scene.points().size() == 0);
    CHECK(scene.lost() == 0);
  }

  TEST_CASE("event points are followed into the negative and back, image points are not") {
    for (const FeatureKind kind : {FeatureKind::kEventPoint, FeatureKind::kImagePoint}) {
      CAPTURE(static_cast<int>(kind));
      OfferedScene scene(kind);
      const auto x_at = [](int k) { return 1.3 * kOnePixelAtOneMetre * k; };
      scene.show(pose_at(x_at(0), 0, -1), false, grid_of_corners(15));
      std::vector<PointMeasurement> begun(scene.points().begin(), scene.points().end());
      scene.show(pose_at(x_at(1), 0, -1), false, {});
      const std::size_t followed = scene.points().size();
      REQUIRE(followed > begun.size() / 2);
      scene.show(pose_at(x_at(2), 0, -1), true, {});
      if (kind == FeatureKind::kImagePoint) {
        CHECK(scene.points().size() < followed / 10);
        continue;
      }
      CHECK(scene.points().size() > followed * 8 / 10);
      scene.show(pose_at(x_at(3), 0, -1), true, {});   // goes on in the negative
      scene.show(pose_at(x_at(4), 0, -1), false, {});  // and back
      CHECK(scene.points().size() > followed * 6 / 10);
      std::vector<double> errors_px;
      for (const PointMeasurement& p : scene.points()) {
        CHECK(p.track_length == 5);
        for (const PointMeasurement& b : begun)
          if (b.id == p.id)
            errors_px.push_back(
                std::hypot(p.raw_px[0] - (b.raw_px[0] - 4 * 1.3), p.raw_px[1] - b.raw_px[1]));
      }
      std::sort(errors_px.begin(), errors_px.end());
      CHECK(support::quantile(errors_px, 0.5) < 0.2);
    }
  }
}

}  // namespace pled
