#include "pled_vins/pipeline/event_admission.hpp"

#include <doctest/doctest.h>

namespace {

using namespace pled;

/// `images` image points followed for `length` frames, then event points first ... first + events.
FrameMeasurement frame(std::size_t images, std::uint32_t length, FeatureId first,
                       std::size_t events) {
  FrameMeasurement out;
  for (std::size_t k = 0; k < images; ++k) {
    PointMeasurement p;
    p.id = static_cast<FeatureId>(k + 1);
    p.track_length = length;
    REQUIRE(out.points.push_back(p));
  }
  for (std::size_t k = 0; k < events; ++k) {
    PointMeasurement p;
    p.id = first + static_cast<FeatureId>(k);
    p.kind = FeatureKind::kEventPoint;
    p.track_length = kSettledSights;
    REQUIRE(out.points.push_back(p));
  }
  return out;
}

std::size_t admitted(const FrameMeasurement& f) {
  std::size_t n = 0;
  for (const PointMeasurement& p : f.points)
    n += p.kind == FeatureKind::kEventPoint && p.for_solver ? 1U : 0U;
  return n;
}

}  // namespace

TEST_SUITE("pipeline.event_admission") {
  TEST_CASE("where frames show enough long tracks no event point is admitted") {
    EventAdmission admission;
    FrameMeasurement f = frame(EventAdmission::kEnough, EventAdmission::kSettled, 1000, 30);
    admission.decide(f, true);
    CHECK(admitted(f) == 0);
    for (std::size_t k = 0; k < EventAdmission::kEnough; ++k) CHECK(f.points[k].for_solver);
  }

  TEST_CASE("as many are admitted as long tracks are missing, the first ones") {
    EventAdmission admission;
    FrameMeasurement f = frame(50, EventAdmission::kSettled, 1000, 30);
    admission.decide(f, true);
    CHECK(admitted(f) == EventAdmission::kEnough - 50);
    CHECK(f.points[50].for_solver);
    CHECK_FALSE(f.points[79].for_solver);
  }

  TEST_CASE("one that was admitted stays until it is lost, even when frames recover") {
    EventAdmission admission;
    FrameMeasurement dark = frame(55, EventAdmission::kSettled, 1000, 10);
    admission.decide(dark, true);
    REQUIRE(admitted(dark) == 5);
    FrameMeasurement bright = frame(100, EventAdmission::kSettled, 1002, 10);  // 1000, 1001 lost
    admission.decide(bright, true);
    CHECK(admitted(bright) == 3);
    FrameMeasurement later =
        frame(100, EventAdmission::kSettled, 1000, 10);  // ids are never reused
    admission.decide(later, true);
    CHECK(admitted(later) == 3);
    CHECK_FALSE(later.points[100].for_solver);
  }

  TEST_CASE("outliers do not count as long tracks, and first frames are not taken for a shortage") {
    EventAdmission admission;
    FrameMeasurement f = frame(70, EventAdmission::kSettled, 1000, 30);
    for (std::size_t k = 0; k < 20; ++k) f.points[k].inlier = false;
    admission.decide(f, true);
    CHECK(admitted(f) == 10);
    admission.reset();
    FrameMeasurement first = frame(100, 1, 1000, 30);
    admission.decide(first, true);
    CHECK(admitted(first) == 0);
  }

  TEST_CASE("before the start only a real shortage lets event points in") {
    EventAdmission admission;
    FrameMeasurement enough =
        frame(EventAdmission::kEnoughToStart, EventAdmission::kSettled, 1000, 30);
    admission.decide(enough, false);
    CHECK(admitted(enough) == 0);
    FrameMeasurement few =
        frame(EventAdmission::kEnoughToStart - 4, EventAdmission::kSettled, 1000, 30);
    admission.decide(few, false);
    CHECK(admitted(few) == 4);
  }

  TEST_CASE("the first sights of an event point are not admitted, with frames or without") {
    EventAdmission admission;
    FrameMeasurement f = frame(0, 1, 1000, 3);
    f.points[0].track_length = 1;
    f.points[1].track_length = kSettledSights - 1;
    f.points[2].track_length = kSettledSights;
    FrameMeasurement without_frames = f;
    admission.decide(f, true);
    admit_settled(without_frames);
    for (const FrameMeasurement& m : {f, without_frames}) {
      CHECK_FALSE(m.points[0].for_solver);
      CHECK_FALSE(m.points[1].for_solver);
      CHECK(m.points[2].for_solver);
    }
  }
}
