#include <doctest/doctest.h>

#include "support/reliability/rotating_edges.hpp"

namespace pled {
namespace {

constexpr Duration kLength{300'000};
constexpr std::int64_t kFrame_us = 33'333;

support::RewarpComparison compare(const Eigen::Vector3d& rate_radps) {
  const support::RotatingEdges scene(rate_radps, kLength, 1);
  return support::compare_with_rewarp(scene, kLength, kFrame_us);
}

}  // namespace

TEST_SUITE("reliability.rewarp") {
  TEST_CASE("a camera that does not turn gets the same scores as from warping anew") {
    const support::RewarpComparison c = compare(Eigen::Vector3d::Zero());
    CHECK(c.anchored.pixels > 1000);
    CHECK(c.anchored.mean < 1e-9);
    CHECK(c.anchored_pooled.mean < 1e-9);
    CHECK(c.half_pixel.mean < 1e-9);  // nothing is carried, so all events round alike
  }

  TEST_CASE(
      "anchors differ from warping anew by no more than half a pixel of the grid's place does") {
    for (const double rate_radps : {0.1, 0.5, 2.0}) {
      const support::RewarpComparison c = compare({0.2 * rate_radps, rate_radps, 0.1 * rate_radps});
      CAPTURE(rate_radps);
      MESSAGE(rate_radps << " rad/s, " << c.anchored.pixels << " pixels, " << c.anchors
                         << " anchors: mean |ds| " << c.anchored.mean << " (half a pixel: "
                         << c.half_pixel.mean << "), pooled " << c.anchored_pooled.mean << " ("
                         << c.half_pixel_pooled.mean << "), beyond the grid " << c.beyond_grid);
      CHECK(c.anchored.pixels > 1000);
      CHECK(c.anchored.mean > 0.0);
      CHECK(c.anchored.mean < c.half_pixel.mean);
      CHECK(c.anchored_pooled.mean < c.half_pixel_pooled.mean);
      CHECK(c.anchored_pooled.mean < c.anchored.mean);
    }
  }
}
}  // namespace pled
