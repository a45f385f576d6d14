#include "pled_vins/backend/line_book.hpp"

#include <cmath>
#include <memory>

#include <doctest/doctest.h>

#include "pled_vins/backend/landmark_book.hpp"

namespace pled {
namespace {

/// Eight states a step apart along x, looking along z from 4 m at a wall of lines.
struct Wall {
  static constexpr int kStates = 8;
  static constexpr double kStep_m = 0.1;

  Wall() : window(std::make_unique<SlidingWindow>()) {
    rig.num_cameras = 1;
    rig.cameras[0].fx_px = rig.cameras[0].fy_px = 200.0;
    settings = make_factor_settings({}, rig);
    for (int k = 0; k < kStates; ++k)
      window->push_state()->x.p_wb = Eigen::Vector3d(kStep_m * k, 0.01 * (k % 3), 0.0);
  }

  /// How state k sees the piece from a to b.
  LineMeasurement see(FeatureId id, int k, const Eigen::Vector3d& a,
                      const Eigen::Vector3d& b) const {
    LineMeasurement out;
    out.id = id;
    const Eigen::Vector3d p = window->state(static_cast<std::size_t>(k)).x.p_wb;
    const Eigen::Vector2d start = (a - p).hnormalized(), end = (b - p).hnormalized();
    out.bearing_xy = {{{start.x(), start.y()}, {end.x(), end.y()}}};
    return out;
  }

  /// Notes a line that moves by `step_m` a state, in all states.
  void watch(FeatureId id, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
             const Eigen::Vector3d& step_m = Eigen::Vector3d::Zero()) {
    for (int k = 0; k < kStates; ++k) {
      FrameMeasurement frame;
      REQUIRE(frame.lines.push_back(see(id, k, a + k * step_m, b + k * step_m)));
      book.observe(*window, frame, static_cast<std::size_t>(k));
    }
  }

  std::unique_ptr<SlidingWindow> window;
  RigCalibration rig;
  FactorSettings settings;
  LineBook book{rig, settings, 4};
};

const Eigen::Vector3d kTop(0.2, -0.8, 4.0), kBottom(0.5, 0.9, 3.5);

/// One frame of the newest state with one rejected line or point, and what time tells of it.
template <typename Book, typename Feature, typename List>
void show(const Book& book, SlidingWindow& window, Feature feature, List FrameMeasurement::*list,
          double w_temporal) {
  FrameMeasurement frame;
  feature.w_temporal = w_temporal;
  REQUIRE((frame.*list).push_back(feature));
  book.observe(window, frame, Wall::kStates - 1);
}

}  // namespace

TEST_SUITE("backend.line_book") {
  TEST_CASE("a line at rest is triangulated to where it is and believed") {
    Wall wall;
    wall.watch(7, kTop, kBottom);
    CHECK(wall.book.prepare(*wall.window) == 1);
    const LineLandmark& line = wall.window->lines[0];
    REQUIRE(line.in_solver);
    const PluckerLine found = to_plucker(line.line());
    for (const Eigen::Vector3d& p : {kTop, kBottom}) {
      const auto nearest = nearest_point(found, p - line.origin_world());
      REQUIRE(nearest);
      CHECK((*nearest + line.origin_world() - p).norm() < 1e-6);
    }
    wall.book.judge(*wall.window);
    CHECK_FALSE(line.rejected);
    CHECK(line.weight == doctest::Approx(1.0).epsilon(1e-6));
    CHECK(line.reliability.w > 0.95);
  }

  TEST_CASE("a line that moves across itself is not believed") {
    Wall wall;
    // Up and down: no other depth explains that.
    for (int k = 0; k < Wall::kStates; ++k) {
      const Eigen::Vector3d way(0.06 * (k % 2), 0, 0);
      FrameMeasurement frame;
      REQUIRE(frame.lines.push_back(wall.see(7, k, kTop + way, kBottom + way)));
      wall.book.observe(*wall.window, frame, static_cast<std::size_t>(k));
    }
    (void)wall.book.prepare(*wall.window);
    wall.book.judge(*wall.window);
    const LineLandmark& line = wall.window->lines[0];
    CHECK((!line.in_solver || line.rejected));
  }

  TEST_CASE("motion along a line tells nothing of it: it takes no part") {
    Wall wall;
    for (std::size_t k = 0; k < Wall::kStates; ++k) wall.window->state(k).x.p_wb.y() = 0.0;
    wall.watch(7, {-1.0, 0.3, 4.0}, {1.0, 0.3, 4.0});
    CHECK(wall.book.prepare(*wall.window) == 0);
    CHECK_FALSE(wall.window->lines[0].has_line);
  }

  TEST_CASE("no more lines are solved than there is room for, living ones first") {
    Wall wall;
    // Old ones, which the newest state does not see, and living ones, in more frames than one
    // holds.
    const auto place = [](FeatureId id) {
      return Eigen::Vector3d(0.01 * static_cast<double>(id % 100), 0.0, 0.0);
    };
    for (FeatureId id = 1; id <= 160; ++id) {
      const int states = id <= 80 ? Wall::kStates - 1 : Wall::kStates;
      for (int k = 0; k < states; ++k) {
        FrameMeasurement frame;
        REQUIRE(frame.lines.push_back(wall.see(id, k, kTop + place(id), kBottom + place(id))));
        LineLandmark* known = wall.window->find_line(id);
        if (known == nullptr) {
          LineLandmark fresh;
          fresh.id = id;
          REQUIRE(wall.window->lines.push_back(fresh));
          known = wall.window->find_line(id);
        }
        const LineMeasurement& seen = frame.lines[0];
        REQUIRE(known->observations.push_back(
            {static_cast<std::uint8_t>(k), 0, seen.bearing_xy[0], seen.bearing_xy[1], {}, {}}));
      }
    }
    CHECK(wall.book.prepare(*wall.window) == limits::kMaxLines);
    for (const LineLandmark& line : wall.window->lines)
      if (line.id <= 80) CHECK_FALSE(line.in_solver);
  }

  TEST_CASE("what was found to move and has stopped is believed again, and only then") {
    Wall wall;
    const LandmarkBook points(wall.rig, wall.settings, 3);
    const LineMeasurement line = wall.see(7, Wall::kStates - 1, kTop, kBottom);
    PointMeasurement point;
    point.id = 3;
    for (const double w_temporal : {0.95, 0.5}) {
      CAPTURE(w_temporal);
      wall.window->landmarks.clear();
      wall.window->lines.clear();
      show(points, *wall.window, point, &FrameMeasurement::points, 0.1);
      show(wall.book, *wall.window, line, &FrameMeasurement::lines, 0.1);
      wall.window->landmarks[0].rejected = wall.window->lines[0].rejected = true;
      for (std::size_t k = 0; k < limits::kCueFrames + 1; ++k) {
        CHECK(wall.window->landmarks[0].rejected);
        CHECK(wall.window->lines[0].rejected);
        show(points, *wall.window, point, &FrameMeasurement::points, w_temporal);
        show(wall.book, *wall.window, line, &FrameMeasurement::lines, w_temporal);
      }
      const bool parked = w_temporal > 0.9;
      CHECK(wall.window->landmarks[0].rejected != parked);
      CHECK(wall.window->lines[0].rejected != parked);
      // Its old sightings are of another place.
      if (parked) CHECK(wall.window->lines[0].observations.size() == 1);
    }
  }
}

}  // namespace pled
