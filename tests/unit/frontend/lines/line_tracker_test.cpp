#include "pled_vins/frontend/lines/line_tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include "pled_vins/geometry/so3.hpp"
#include "support/frontend/drawn_edges.hpp"

namespace pled {
namespace {

using support::GreyImage;
using support::Rectangle;

/// Rectangles on a wall far off, seen by a camera that only turns.
class Wall {
 public:
  explicit Wall(const Camera& camera) : camera_(camera) {
    for (int i = 0; i < 6; ++i)
      for (int k = 0; k < 2; ++k)
        boxes_.push_back(
            Rectangle({0.55 * i - 0.9, 0.5 * k - 0.25}, 0.16, 0.13, 0.1 * i - 0.2 * k));
    const CameraCalibration& c = camera.calibration();
    for (int y = 0; y < c.height_px; ++y)
      for (int x = 0; x < c.width_px; ++x)
        for (int i = 0; i < kSamples; ++i) {
          const std::optional<Eigen::Vector2d> b =
              camera.undistort({x + (i % 3 - 1) / 3.0, y + (static_cast<double>(i / 3) - 1) / 3.0});
          rays_.push_back(b ? b->homogeneous() : Eigen::Vector3d(0, 0, 1));
        }
  }

  [[nodiscard]] GreyImage see(const Eigen::Matrix3d& R_wall_cam) const {
    GreyImage image(camera_.calibration().width_px, camera_.calibration().height_px);
    for (std::size_t p = 0; p < image.pixels.size(); ++p) {
      double sum = 0.0;
      for (std::size_t i = 0; i < kSamples; ++i) {
        const Eigen::Vector3d ray = R_wall_cam * rays_[kSamples * p + i];
        sum += grey(ray.x() / ray.z(), ray.y() / ray.z());
      }
      image.pixels[p] = static_cast<std::uint8_t>(std::lround(sum / kSamples));
    }
    return image;
  }

  /// The edge a line lies on, and how far off in px the farther of its ends is.
  struct Edge {
    std::size_t index = 0;
    double off_px = 1e9;
  };
  [[nodiscard]] Edge edge_of(const LineMeasurement& line, const Eigen::Matrix3d& R_wall_cam) const {
    Edge best;
    for (std::size_t i = 0; i < boxes_.size(); ++i)
      for (std::size_t k = 0; k < 4; ++k) {
        const Eigen::Vector3d normal =
            (R_wall_cam.transpose() * boxes_[i].corner((k + 1) % 4).homogeneous())
                .cross(R_wall_cam.transpose() * boxes_[i].corner(k).homogeneous());
        const double unit = camera_.focal_px() / normal.head<2>().norm();
        double off = 0.0;
        Eigen::Vector2d middle = Eigen::Vector2d::Zero();
        for (const auto& end : line.bearing_xy) {
          const Eigen::Vector3d b(end[0], end[1], 1.0);
          off = std::max(off, unit * std::abs(normal.dot(b)));
          middle += 0.5 * (R_wall_cam * b).hnormalized();
        }
        const Eigen::Vector2d beside = boxes_[i].inner(middle.x(), middle.y());
        const bool at_box = std::abs(beside.x()) < 0.18 && std::abs(beside.y()) < 0.15;
        if (at_box && off < best.off_px) best = {4 * i + k, off};
      }
    return best;
  }

 private:
  static constexpr int kSamples = 9;  ///< a pixel

  [[nodiscard]] double grey(double x, double y) const {
    for (std::size_t i = 0; i < boxes_.size(); ++i)
      if (boxes_[i].holds(x, y)) return 120.0 + 10.0 * static_cast<double>(i);
    return 60.0;
  }

  Camera camera_;
  std::vector<Rectangle> boxes_;
  std::vector<Eigen::Vector3d> rays_;
};

FrameView view_of(const GreyImage& image, std::int64_t t_us) {
  FrameView frame;
  frame.t = Timestamp{t_us};
  frame.stamp_ns = t_us * 1000;
  frame.image = image.view();
  return frame;
}

/// A tracker with its memory that is shown pictures 50 ms apart.
class Watch {
 public:
  explicit Watch(const Camera& camera, const LineConfig& config = {}, const LineRole& role = {})
      : storage_(std::make_unique<LineStorage<240, 180>>()),
        tracker_(std::make_unique<LineTracker>(config, camera, storage_->view(), role)) {}

  const LineFrame& show(const GreyImage& image,
                        const std::optional<Eigen::Quaterniond>& R_prev_cur = std::nullopt) {
    t_us_ += 50'000;
    REQUIRE(tracker_->track(view_of(image, t_us_), Timestamp{t_us_}, R_prev_cur, out_));
    return out_;
  }
  [[nodiscard]] LineTracker& tracker() { return *tracker_; }
  [[nodiscard]] const LineFrame& seen() const { return out_; }

 private:
  std::unique_ptr<LineStorage<240, 180>> storage_;
  std::unique_ptr<LineTracker> tracker_;
  std::int64_t t_us_ = 0;
  LineFrame out_;
};

Eigen::Quaterniond turned(double yaw_rad, double pitch_rad = 0.0, double roll_rad = 0.0) {
  return so3::exp({pitch_rad, yaw_rad, roll_rad});
}

GreyImage stripes(double shift_px) {
  return support::draw(240, 180, [&](double x, double y) {
    return std::fmod(y + 0.05 * x + 80.0 - shift_px, 8.0) < 4.0 ? 200.0 : 50.0;
  });
}

GreyImage one_edge(double y_px) {
  return support::draw(
      240, 180, [&](double x, double y) { return y > y_px + 0.1 * (x - 120.0) ? 180.0 : 60.0; });
}

std::set<FeatureId> ids_of(const LineFrame& frame) {
  std::set<FeatureId> ids;
  for (const LineMeasurement& line : frame.lines) ids.insert(line.id);
  return ids;
}

}  // namespace

TEST_SUITE("frontend.line_tracker") {
  TEST_CASE("through a fast turn each id stays on its edge, with a lens and without") {
    for (const bool distorted : {false, true}) {
      CAPTURE(distorted);
      const Camera camera = support::davis240_camera(distorted);
      const Wall wall(camera);
      Watch watch(camera);
      const Eigen::Quaterniond step = turned(0.07, 0.01, 0.02);  // 14 px a picture
      Eigen::Quaterniond R_wall_cam = Eigen::Quaterniond::Identity();
      std::map<FeatureId, std::size_t> edge_of_id;
      std::map<FeatureId, std::uint32_t> seen_times;
      std::size_t lines = 0;
      for (int k = 0; k < 10; ++k) {
        CAPTURE(k);
        const Eigen::Matrix3d R = R_wall_cam.toRotationMatrix();
        const LineFrame& frame = watch.show(wall.see(R), step);
        CHECK(frame.lines.size() >= 12);
        CHECK(ids_of(frame).size() == frame.lines.size());
        for (const LineMeasurement& line : frame.lines) {
          ++lines;
          const Wall::Edge edge = wall.edge_of(line, R);
          CHECK(edge.off_px < 1.0);
          const auto [known, is_new] = edge_of_id.emplace(line.id, edge.index);
          CHECK(known->second == edge.index);
          CHECK(line.track_length == ++seen_times[line.id]);
          CHECK(is_new == (line.track_length == 1));
          CHECK(line.inlier);
          CHECK(line.id >= kFirstImageLineId);
        }
        R_wall_cam = R_wall_cam * step;
      }
      // Edges seen in several pictures kept one id: 24 ids would be too few for the ones that come.
      std::set<std::size_t> edges;
      for (const auto& [id, edge] : edge_of_id) edges.insert(edge);
      CHECK(edge_of_id.size() <= edges.size() + edges.size() / 5);
      CHECK(lines >= 5 * edge_of_id.size() / 2);
    }
  }

  TEST_CASE("without the rotation the same turn loses every line") {
    const Camera camera = support::davis240_camera(false);
    const Wall wall(camera);
    Watch watch(camera);
    const Eigen::Quaterniond step = turned(0.11);  // 22 px
    (void)watch.show(wall.see(Eigen::Matrix3d::Identity()));
    (void)watch.show(wall.see(step.toRotationMatrix()));
    int followed = 0;
    for (const LineMeasurement& line : watch.seen().lines)
      if (line.track_length > 1 &&
          std::abs(line.bearing_xy[0][0] - line.bearing_xy[1][0]) < 0.05)  // upright edges
        ++followed;
    CHECK(followed == 0);
  }

  TEST_CASE("bearings and raw pixels are of the same ends, and lengths between them") {
    const Camera camera = support::davis240_camera(true);
    const Wall wall(camera);
    Watch watch(camera, {}, {.camera_index = 1});
    const LineFrame& frame = watch.show(wall.see(Eigen::Matrix3d::Identity()));
    REQUIRE(frame.lines.size() >= 12);
    CHECK(frame.t.us == 50'000);
    CHECK(frame.stamp_ns == 50'000'000);
    for (const LineMeasurement& line : frame.lines) {
      CHECK(line.camera == 1);
      std::array<Eigen::Vector2d, 2> flat;
      for (std::size_t k = 0; k < 2; ++k) {
        const auto bearing = camera.undistort({line.raw_px[k][0], line.raw_px[k][1]});
        REQUIRE(bearing.has_value());
        CHECK(bearing->x() == doctest::Approx(line.bearing_xy[k][0]).epsilon(1e-6));
        CHECK(bearing->y() == doctest::Approx(line.bearing_xy[k][1]).epsilon(1e-6));
        flat[k] = {camera.calibration().fx_px * bearing->x(),
                   camera.calibration().fy_px * bearing->y()};
      }
      CHECK(line.length_px == doctest::Approx((flat[1] - flat[0]).norm()).epsilon(1e-6));
    }
  }

  TEST_CASE("stripes moved by half their distance are not matched rather than matched wrongly") {
    const Camera camera = support::plain_camera(240, 180);
    Watch watch(camera);
    const std::set<FeatureId> before = ids_of(watch.show(stripes(0.0)));
    REQUIRE(before.size() >= 20);
    int between_others = 0;
    for (const LineMeasurement& line : watch.show(stripes(4.0)).lines) {
      const double y = 0.5 * (line.raw_px[0][1] + line.raw_px[1][1]);
      if (y < 20.0 || y > 160.0) continue;  // at the rim a stripe may have one neighbour only
      ++between_others;
      CHECK(line.track_length == 1);
    }
    CHECK(between_others >= 15);
    // Moved by little they keep their ids.
    Watch other(camera);
    const std::set<FeatureId> first = ids_of(other.show(stripes(0.0)));
    const LineFrame& second = other.show(stripes(1.0));
    int followed = 0;
    for (const LineMeasurement& line : second.lines)
      if (line.track_length == 2) ++followed;
    CHECK(followed >= 20);
  }

  TEST_CASE("a line that moves on steadily is followed beyond the search range, and stays inlier") {
    const Camera camera = support::plain_camera(240, 180);
    Watch watch(camera);
    double y = 30.0;
    FeatureId id = 0;
    for (int k = 0; k < 10; ++k) {
      CAPTURE(k);
      const LineFrame& frame = watch.show(one_edge(y));
      REQUIRE(frame.lines.size() == 1);
      if (k == 0) id = frame.lines[0].id;
      CHECK(frame.lines[0].id == id);
      CHECK(frame.lines[0].inlier);
      y += 6.0 + k;  // at last 15 px, more than the 8 px that are searched
    }
  }

  TEST_CASE("a line that jumps ends, and what it jumped to is another") {
    const Camera camera = support::plain_camera(240, 180);
    for (const double jump_px : {1.0, 4.0}) {
      CAPTURE(jump_px);
      Watch watch(camera);
      for (const double y : {60.0, 61.0, 62.0}) (void)watch.show(one_edge(y));
      const FeatureId id = watch.seen().lines[0].id;
      REQUIRE(watch.seen().lines[0].track_length == 3);
      const LineFrame& frame = watch.show(one_edge(63.0 + jump_px));
      REQUIRE(frame.lines.size() == 1);
      const bool goes_on = jump_px < 2.0;
      CHECK((frame.lines[0].id == id) == goes_on);
      CHECK(frame.lines[0].track_length == (goes_on ? 4U : 1U));
      CHECK(frame.lost == (goes_on ? 0U : 1U));
    }
  }

  TEST_CASE("a line missing in two pictures comes back with its id, after three as another") {
    const Camera camera = support::davis240_camera(false);
    const Wall wall(camera);
    const GreyImage blank(240, 180);
    const Eigen::Quaterniond step = turned(0.03);
    for (const int missing : {1, 2, 3}) {
      CAPTURE(missing);
      Watch watch(camera);
      Eigen::Quaterniond R = Eigen::Quaterniond::Identity();
      (void)watch.show(wall.see(R.toRotationMatrix()));
      R = R * step;
      const std::set<FeatureId> before = ids_of(watch.show(wall.see(R.toRotationMatrix()), step));
      std::uint32_t lost = 0;
      for (int k = 0; k < missing; ++k) {
        R = R * step;
        CHECK(watch.show(blank, step).lines.empty());
        lost += watch.seen().lost;
      }
      R = R * step;
      const LineFrame& after = watch.show(wall.see(R.toRotationMatrix()), step);
      std::size_t known = 0;
      for (const LineMeasurement& line : after.lines) known += before.count(line.id);
      if (missing < 3) {
        CHECK(lost == 0);
        CHECK(known >= 8);
      } else {
        CHECK(lost >= before.size());
        CHECK(known == 0);
      }
    }
  }

  TEST_CASE("a picture of another size is skipped, and tracks go on after it") {
    const Camera camera = support::plain_camera(240, 180);
    Watch watch(camera);
    const FeatureId id = watch.show(one_edge(60)).lines[0].id;
    LineFrame out = watch.seen();
    CHECK_FALSE(
        watch.tracker().track(view_of(GreyImage(120, 90), 60'000), Timestamp{60'000}, {}, out));
    CHECK(out.lines.empty());
    CHECK(out.stamp_ns == 60'000'000);
    CHECK_FALSE(watch.tracker().track(FrameView{}, Timestamp{70'000}, {}, out));
    const LineFrame& frame = watch.show(one_edge(61));
    REQUIRE(frame.lines.size() == 1);
    CHECK(frame.lines[0].id == id);
  }

  TEST_CASE("a rotation that is not a number counts as unknown") {
    const Camera camera = support::plain_camera(240, 180);
    Watch watch(camera);
    const FeatureId id = watch.show(one_edge(60)).lines[0].id;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const LineFrame& frame = watch.show(one_edge(61), Eigen::Quaterniond(nan, nan, nan, nan));
    REQUIRE(frame.lines.size() == 1);
    CHECK(frame.lines[0].id == id);
  }

  TEST_CASE("lines turned behind the camera end") {
    const Camera camera = support::plain_camera(240, 180);
    Watch watch(camera);
    (void)watch.show(one_edge(60));
    const LineFrame& frame = watch.show(one_edge(60), turned(2.5));
    CHECK(frame.lost == 1);
    REQUIRE(frame.lines.size() == 1);
    CHECK(frame.lines[0].track_length == 1);
  }

  TEST_CASE("ids are of the tracker's own range and not used again after a reset") {
    const Camera camera = support::davis240_camera(false);
    const Wall wall(camera);
    const GreyImage image = wall.see(Eigen::Matrix3d::Identity());
    Watch watch(camera, {}, {.first_id = kFirstEventLineId});
    const std::set<FeatureId> before = ids_of(watch.show(image));
    CHECK(*before.begin() == kFirstEventLineId);
    watch.tracker().reset();
    const LineFrame& frame = watch.show(image);
    CHECK(frame.lines.size() == before.size());
    for (const LineMeasurement& line : frame.lines) {
      CHECK(line.track_length == 1);
      CHECK(before.count(line.id) == 0);
    }
  }

  TEST_CASE("as many lines are followed as wanted, whatever has gone missing") {
    const Camera camera = support::plain_camera(240, 180);
    LineConfig config;
    config.max_lines = 5;
    Watch watch(camera, config);
    for (int k = 0; k < 4; ++k) CHECK(watch.show(stripes(4.0 * k)).lines.size() == 5);
  }

  TEST_CASE("the same pictures give the same bits") {
    const Camera camera = support::davis240_camera(true);
    const Wall wall(camera);
    Watch a(camera);
    Watch b(camera);
    const Eigen::Quaterniond step = turned(0.04, 0.01);
    Eigen::Quaterniond R = Eigen::Quaterniond::Identity();
    for (int k = 0; k < 4; ++k) {
      const GreyImage image = wall.see(R.toRotationMatrix());
      const LineFrame& x = a.show(image, step);
      const LineFrame& y = b.show(image, step);
      REQUIRE(x.lines.size() == y.lines.size());
      CHECK(x.lost == y.lost);
      for (std::size_t i = 0; i < x.lines.size(); ++i) {
        CHECK(x.lines[i].id == y.lines[i].id);
        CHECK(std::memcmp(&x.lines[i].bearing_xy, &y.lines[i].bearing_xy,
                          sizeof x.lines[i].bearing_xy) == 0);
      }
      R = R * step;
    }
  }
}

}  // namespace pled
