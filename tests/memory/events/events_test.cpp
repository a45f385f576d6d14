#include <cstddef>
#include <memory>

#include <doctest/doctest.h>

#include "pled_vins/events/arc_star.hpp"
#include "pled_vins/events/time_surface.hpp"
#include "support/events/edge_stream.hpp"
#include "support/events/surface_fixture.hpp"
#include "support/heap_counter.hpp"

namespace pled {

TEST_SUITE("events.memory") {
  TEST_CASE("no stage goes to the heap") {
    if (!support::heap_is_counted()) return;
    CameraCalibration calibration;
    calibration.width_px = 240;
    calibration.height_px = 180;
    calibration.fx_px = calibration.fy_px = 200.0;
    calibration.cx_px = 120.0;
    calibration.cy_px = 90.0;
    support::EdgeStreamOptions options;
    options.events = 100'000;
    const std::vector<Event> events = support::edge_stream(options);
    support::OwnedSurface owned(240, 180);
    std::vector<float> bearings(UndistortionTable::floats_needed(240, 180));
    std::vector<WarpedPixel> warped(events.size());
    std::vector<float> scratch(TimeSurface::floats_needed(240, 180));
    std::vector<std::uint8_t> grey(240 * 180);
    const auto turn = std::make_unique<TurnHistory>();
    const auto slices = std::make_unique<TurnSlices>();
    const auto arc_star = std::make_unique<ArcStarDetector>(EventConfig{});
    FixedVector<EventCorner, limits::kMaxPoints> corners;
    const ImageView<std::uint8_t> picture{grey.data(), 240, 180, 240};

    const std::size_t before = support::allocations();
    UndistortionTable table;
    REQUIRE(table.build(Camera(calibration), bearings));
    EventWarp warp;
    REQUIRE(warp.build(table, rectified(calibration)));
    const TimeSurface time_surface(20.0);
    for (std::int64_t t = 900'000; t <= 1'050'000; t += 1000) {
      const ImuSample sample{{t}, {0.5, 1.0, -0.5}, {}};
      turn->extend({&sample, 1}, Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity());
    }
    const Timestamp t_ref{1'050'000};
    REQUIRE(turn->slices(t_ref, t_ref - Duration{140'000}, t_ref, warp.slice_error_rad(), *slices));
    owned.surface.insert(events);
    warp.warp(events, *slices, warped);
    for (const Meeting meeting : {Meeting::kNewest, Meeting::kBlended})
      REQUIRE(time_surface.render(owned.surface, warp, *slices, SurfaceTone::kSigned, meeting,
                                  scratch, picture));
    REQUIRE(time_surface.render(owned.surface, t_ref, SurfaceTone::kUnsigned, picture));
    arc_star->detect(owned.surface, t_ref, {}, limits::kMaxPoints, corners);
    CHECK(support::allocations() == before);
    CHECK(corners.size() > 20);
  }
}

}  // namespace pled
