#include "src/backend/arrival_check.hpp"

#include <cmath>
#include <memory>

#include <doctest/doctest.h>

#include "pled_vins/backend/landmark_book.hpp"
#include "pled_vins/backend/line_book.hpp"

namespace pled {
namespace {

constexpr FeatureId kId = 5;
constexpr double kFocal_px = 200.0;
const Eigen::Vector3d kPoint(0.2, -0.1, 4.0);  // metres, world

/// Six states a step apart along x that look along z.
struct Row {
  static constexpr std::size_t kStates = 6;

  Row() : window(std::make_unique<SlidingWindow>()) {
    rig.num_cameras = 1;
    rig.cameras[0].fx_px = rig.cameras[0].fy_px = kFocal_px;
    settings = make_factor_settings({}, rig);
    for (std::size_t k = 0; k < kStates; ++k)
      window->push_state()->x.p_wb = Eigen::Vector3d(0.1 * static_cast<double>(k), 0.0, 0.0);
  }

  /// The point as state k sees it, `off_px` (u, v) beside its place.
  void see(std::size_t k, const Eigen::Vector2d& off_px = Eigen::Vector2d::Zero()) {
    const Eigen::Vector2d xy =
        (kPoint - window->state(k).x.p_wb).hnormalized() + off_px / kFocal_px;
    FrameMeasurement frame;
    PointMeasurement point;
    point.id = kId;
    point.bearing_xy = {xy.x(), xy.y()};
    REQUIRE(frame.points.push_back(point));
    book.observe(*window, frame, k);
  }

  /// Seen by all states but the last; with a depth that the books have judged if asked for.
  void see_past(bool judged) {
    for (std::size_t k = 0; k + 1 < kStates; ++k) see(k);
    if (!judged) return;
    book.prepare(*window);
    book.judge(*window);
    REQUIRE(point().has_depth);
    REQUIRE(point().depth_information_m2 > 0.0);
  }

  /// Whether the newest sighting is still there.
  bool let_in(const Eigen::Vector2d& off_px) {
    see(kStates - 1, off_px);
    turn_away_movers(*window, rig, settings);
    return point().observations.back().state == kStates - 1;
  }

  Landmark& point() { return *window->find(kId); }

  std::unique_ptr<SlidingWindow> window;
  RigCalibration rig;
  FactorSettings settings;
  LandmarkBook book{rig, settings, 3};
};

bool let_in(bool judged, double u_px, double v_px) {
  Row row;
  row.see_past(judged);
  return row.let_in({u_px, v_px});
}

}  // namespace

TEST_SUITE("backend.arrival_check") {
  TEST_CASE("a point whose depth is known may come to its place and nowhere else") {
    CHECK(let_in(true, 0.0, 0.0));
    CHECK(let_in(true, 0.0, 1.5));
    CHECK_FALSE(let_in(true, 0.0, 5.0));
    CHECK_FALSE(let_in(true, 0.0, -5.0));
    CHECK_FALSE(let_in(true, 20.0, 0.0));
    CHECK_FALSE(let_in(true, -20.0, 0.0));
  }

  TEST_CASE("a point whose depth is not known may come anywhere on its epipolar piece") {
    // It lies at 25 px of parallax: 0 at infinity, past 300 px at the nearest depth allowed.
    CHECK(let_in(false, 0.0, 0.0));
    CHECK(let_in(false, 20.0, 0.0));
    CHECK(let_in(false, -100.0, 0.0));
    CHECK_FALSE(let_in(false, 40.0, 0.0));  // behind infinity
    CHECK_FALSE(let_in(false, 0.0, 5.0));
    CHECK_FALSE(let_in(false, -100.0, 20.0));
  }

  TEST_CASE("what fails thrice on end is rejected, what comes right in between is not") {
    Row row;
    row.see_past(true);
    CHECK_FALSE(row.let_in({0.0, 8.0}));
    CHECK_FALSE(row.let_in({0.0, 8.0}));
    CHECK_FALSE(row.point().rejected);
    CHECK(row.let_in({0.0, 0.0}));
    CHECK(row.point().strikes == 0);
    row.point().observations.pop_back();
    for (int k = 0; k < 3; ++k) CHECK_FALSE(row.let_in({0.0, 8.0}));
    CHECK(row.point().rejected);
  }

  TEST_CASE("a sighting that is not a number is turned away") {
    CHECK_FALSE(let_in(true, 0.0, std::nan("")));
    CHECK_FALSE(let_in(false, 0.0, std::nan("")));
  }

  TEST_CASE("published modes of the weights have no such check") {
    Row row;
    row.settings.robust.mode = RobustMode::kPaper;
    row.see_past(true);
    CHECK(row.let_in({0.0, 30.0}));
  }

  TEST_CASE("a line may slide along itself and not across") {
    const Eigen::Vector3d a(0.2, -0.8, 4.0), b(0.4, 0.9, 4.0);
    const auto comes = [&](const Eigen::Vector2d& off_px) {
      Row row;
      LineBook book(row.rig, row.settings, 4);
      for (std::size_t k = 0; k < Row::kStates; ++k) {
        const bool last = k + 1 == Row::kStates;
        if (last) book.prepare(*row.window);
        const Eigen::Vector3d p = row.window->state(k).x.p_wb;
        const Eigen::Vector2d off =
            last ? Eigen::Vector2d(off_px / kFocal_px) : Eigen::Vector2d::Zero();
        const Eigen::Vector2d start = (a - p).hnormalized() + off,
                              end = (b - p).hnormalized() + off;
        FrameMeasurement frame;
        LineMeasurement seen;
        seen.id = kId;
        seen.bearing_xy = {{{start.x(), start.y()}, {end.x(), end.y()}}};
        REQUIRE(frame.lines.push_back(seen));
        book.observe(*row.window, frame, k);
      }
      REQUIRE(row.window->find_line(kId)->has_line);
      turn_away_movers(*row.window, row.rig, row.settings);
      return row.window->find_line(kId)->observations.back().state == Row::kStates - 1;
    };
    const Eigen::Vector2d along = (b - a).head<2>().normalized();
    CHECK(comes(Eigen::Vector2d::Zero()));
    CHECK(comes(30.0 * along));
    CHECK_FALSE(comes({-along.y() * 15.0, along.x() * 15.0}));
  }
}

}  // namespace pled
