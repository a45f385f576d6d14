// How fast the ends of a line go across it.

#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include <doctest/doctest.h>

#include "pled_vins/frontend/lines/line_tracker.hpp"
#include "pled_vins/geometry/so3.hpp"
#include "support/frontend/drawn_edges.hpp"

namespace pled {
namespace {

using support::GreyImage;

constexpr double kFocal_px = 200.0;  // of support::plain_camera
constexpr double kStep_s = 0.05;
/// A drawn edge is found to 0.15 px: twice that in one step.
constexpr double kRateError_ps = 0.3 / kFocal_px / kStep_s;

/// A tracker with its memory, without anything that the test does not tell it.
class Watch {
 public:
  Watch() { out_.lines.clear(); }

  const LineFrame& show(const GreyImage& image, double t_s,
                        const std::optional<Eigen::Quaterniond>& R_prev_cur = std::nullopt) {
    FrameView frame;
    frame.image = image.view();
    const Timestamp t = Timestamp{} + Duration::from_s(t_s);
    REQUIRE(tracker_->track(frame, t, R_prev_cur, out_));
    return out_;
  }
  [[nodiscard]] LineTracker& tracker() { return *tracker_; }

 private:
  std::unique_ptr<LineStorage<240, 180>> storage_ = std::make_unique<LineStorage<240, 180>>();
  std::unique_ptr<LineTracker> tracker_ = std::make_unique<LineTracker>(
      LineConfig{}, support::plain_camera(240, 180), storage_->view());
  LineFrame out_;
};

/// Bright where the normal points to, from the middle of the picture `offset_px` along it.
GreyImage edge(const Eigen::Vector2d& normal, double offset_px) {
  return support::draw(240, 180, [&](double x, double y) {
    return normal.dot(Eigen::Vector2d(x - 119.5, y - 89.5)) > offset_px ? 180.0 : 60.0;
  });
}

Eigen::Vector2d direction(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }

Eigen::Vector2d at(const std::array<std::array<double, 2>, 2>& ends, std::size_t k) {
  return {ends[k][0], ends[k][1]};
}

}  // namespace

TEST_SUITE("frontend.line_rates") {
  TEST_CASE("a new line has no rate, and one that stands has next to none") {
    Watch watch;
    const GreyImage image = edge(direction(0.4), 10.0);
    const LineFrame& first = watch.show(image, 1.0);
    REQUIRE(first.lines.size() == 1);
    for (std::size_t k = 0; k < 2; ++k)
      CHECK(at(first.lines[0].bearing_rate_xyps, k) == Eigen::Vector2d(0, 0));
    const LineFrame& second = watch.show(image, 1.05);
    REQUIRE(second.lines.size() == 1);
    for (std::size_t k = 0; k < 2; ++k)
      CHECK(at(second.lines[0].bearing_rate_xyps, k).norm() < 1e-9);
  }

  TEST_CASE("an edge that goes on has both ends go along its normal as fast, whatever its tilt") {
    for (const double tilt_rad : {0.0, 0.3, 1.2, 1.57, 2.6, 4.0}) {
      CAPTURE(tilt_rad);
      Watch watch;
      const Eigen::Vector2d n = direction(tilt_rad);
      for (int i = 0; i < 5; ++i) {
        const LineFrame& frame = watch.show(edge(n, 4.0 * i - 8.0), kStep_s * i);
        REQUIRE(frame.lines.size() == 1);
        CHECK(frame.lines[0].track_length == static_cast<std::uint32_t>(i) + 1);
        if (i == 0) continue;
        const Eigen::Vector2d want = 4.0 / kFocal_px / kStep_s * n;
        for (std::size_t k = 0; k < 2; ++k)
          CHECK((at(frame.lines[0].bearing_rate_xyps, k) - want).norm() < kRateError_ps);
      }
    }
  }

  TEST_CASE("rates hold the camera's turning, whether the tracker is told of it or not") {
    // About the optical axis: the edge turns in the picture by -roll.
    constexpr double kRoll_rad = 0.03;
    for (const bool told : {true, false}) {
      CAPTURE(told);
      Watch watch;
      std::optional<Eigen::Quaterniond> turn;
      if (told) turn = so3::exp({0.0, 0.0, kRoll_rad});
      for (int i = 0; i < 4; ++i) {
        const Eigen::Vector2d n = direction(0.3 - kRoll_rad * i);
        const LineFrame& frame = watch.show(edge(n, 5.0), kStep_s * i, turn);
        REQUIRE(frame.lines.size() == 1);
        if (i == 0) continue;
        REQUIRE(frame.lines[0].track_length == static_cast<std::uint32_t>(i) + 1);
        for (std::size_t k = 0; k < 2; ++k) {
          const Eigen::Vector2d e = at(frame.lines[0].bearing_xy, k);
          const Eigen::Vector2d whole = -kRoll_rad / kStep_s * Eigen::Vector2d(-e.y(), e.x());
          const Eigen::Vector2d across = n.dot(whole) * n;
          // Half a step of turning is what first order leaves out.
          const double tolerance = kRateError_ps + 0.5 * kRoll_rad * across.norm();
          CHECK((at(frame.lines[0].bearing_rate_xyps, k) - across).norm() < tolerance);
          CHECK(across.norm() > 4 * tolerance);
        }
      }
    }
  }

  TEST_CASE("after a picture without the line its rate is that since it was seen") {
    Watch watch;
    const Eigen::Vector2d n = direction(1.2);
    (void)watch.show(edge(n, 0.0), 1.0);
    (void)watch.show(edge(n, 3.0), 1.05);
    CHECK(watch.show(GreyImage(240, 180), 1.10).lines.empty());
    const LineFrame& frame = watch.show(edge(n, 9.0), 1.15);
    REQUIRE(frame.lines.size() == 1);
    REQUIRE(frame.lines[0].track_length == 3);
    const Eigen::Vector2d want = 6.0 / kFocal_px / 0.10 * n;
    for (std::size_t k = 0; k < 2; ++k)
      CHECK((at(frame.lines[0].bearing_rate_xyps, k) - want).norm() < kRateError_ps);
  }

  TEST_CASE("a clock that is set right changes times, not rates") {
    Watch watch;
    const Eigen::Vector2d n = direction(1.2);
    (void)watch.show(edge(n, 0.0), 1.0);
    const FeatureId id = watch.show(edge(n, 2.0), 1.05).lines[0].id;
    watch.tracker().shift_clock(Duration::from_ms(40));
    const LineFrame& frame = watch.show(edge(n, 4.0), 1.14);
    REQUIRE(frame.lines.size() == 1);
    CHECK(frame.lines[0].id == id);
    CHECK(frame.lines[0].inlier);
    const Eigen::Vector2d want = 2.0 / kFocal_px / kStep_s * n;
    for (std::size_t k = 0; k < 2; ++k)
      CHECK((at(frame.lines[0].bearing_rate_xyps, k) - want).norm() < kRateError_ps);
  }
}

}  // namespace pled
