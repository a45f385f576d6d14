#include "src/report/feature_digest.hpp"

#include <cmath>
#include <string>
#include <variant>

#include <doctest/doctest.h>

#include "unit/config/text_file.hpp"

namespace {

using namespace pled::report;
using pled::support::TextFile;

constexpr const char* kHeader =
    "t,id,kind,u0_px,v0_px,u1_px,v1_px,w_temporal,w_geometric,w,observations,used\n";

/// `frames` frames 0.05 s apart with two points each, of weights 0.5 and none.
std::string features_of(int frames) {
  std::string text = kHeader;
  for (int i = 0; i < frames; ++i) {
    const std::string t = std::to_string(0.05 * i);
    text += t + ",1,image_point,10,10,,,,0.5,0.5,3,1\n";
    text += t + ",2,event_point,20,20,,,,,,1,0\n";
  }
  return text;
}

FeatureDigest digest_of(const std::string& text, std::size_t max_moments) {
  const TextFile file("features.csv", text);
  auto digest = digest_features(file.path(), nullptr, max_moments);
  REQUIRE(std::holds_alternative<FeatureDigest>(digest));
  return std::get<FeatureDigest>(std::move(digest));
}

TEST_SUITE("report.feature_digest") {
  TEST_CASE("each frame is counted by kind, use and mean weight") {
    const FeatureDigest digest = digest_of(features_of(3), 16);
    REQUIRE(digest.frames.size() == 3);
    const FrameStats& frame = digest.frames[2];
    CHECK(frame.stamp_ns == 100'000'000);
    CHECK(frame.tracked[static_cast<std::size_t>(Kind::kImagePoint)] == 1);
    CHECK(frame.tracked[static_cast<std::size_t>(Kind::kEventPoint)] == 1);
    CHECK(frame.used == 1);
    CHECK(frame.event_points_used == 0);
    CHECK(frame.mean_w == 0.5);
    CHECK_FALSE(digest.labelled);
  }

  TEST_CASE("temporal weights have a median for each kind of point, of those with evidence") {
    const FeatureDigest digest = digest_of(std::string(kHeader) +
                                               "0,1,image_point,10,10,,,0.9,,,3,1\n"
                                               "0,2,image_point,10,10,,,0.2,,,3,1\n"
                                               "0,3,image_point,10,10,,,,,,3,1\n"
                                               "0,4,image_point,10,10,,,0.5,,,3,1\n"
                                               "0,5,event_point,10,10,,,0.125,,,3,1\n",
                                           16);
    REQUIRE(digest.frames.size() == 1);
    CHECK(digest.frames[0].image_points.still == 0.5);
    CHECK(digest.frames[0].event_points.still == 0.125);
    CHECK(std::isnan(digest.frames[0].event_points.moving));  // nobody knows what moves
    CHECK(digest.frames[0].event_points_used == 1);
  }

  TEST_CASE("a weight is counted in its bin, one without evidence in none") {
    const FeatureDigest digest = digest_of(features_of(5), 16);
    CHECK(digest.w.still[10] == 5);
    CHECK(digest.w_geometric.still[10] == 5);
    CHECK(digest.w_temporal.empty());
    Histogram ends;
    ends.add(0.0, true);
    ends.add(1.0, true);
    CHECK(ends.moving.front() == 1);
    CHECK(ends.moving.back() == 1);
  }

  TEST_CASE("moments are spread evenly, however long the file is") {
    for (const int frames : {1, 2, 15, 16, 17, 63, 64, 65, 500, 5000}) {
      CAPTURE(frames);
      const FeatureDigest digest = digest_of(features_of(frames), 16);
      const auto& moments = digest.moments;
      REQUIRE(moments.size() == static_cast<std::size_t>(std::min(frames, 16)));
      CHECK(moments.front().stamp_ns == 0);
      const double length_ns = 0.05e9 * (frames - 1);
      CHECK(static_cast<double>(moments.back().stamp_ns) >= 0.93 * length_ns);
      for (std::size_t i = 1; i < moments.size(); ++i) {
        const auto step_ns = static_cast<double>(moments[i].stamp_ns - moments[i - 1].stamp_ns);
        CHECK(step_ns > 0.0);
        CHECK(step_ns <= 2.0 * length_ns / static_cast<double>(moments.size() - 1));
        CHECK(moments[i].rows.size() == 2);
      }
    }
  }
}

}  // namespace
