#include <cstddef>

#include <doctest/doctest.h>

#include "support/frontend/tracked_scene.hpp"
#include "support/heap_counter.hpp"

namespace pled {

TEST_SUITE("frontend.frame_tracker.memory") {
  TEST_CASE("track() never goes to the heap") {
    if (!support::heap_is_counted()) return;
    const Camera camera = support::davis240_camera(true);
    const support::PlaneScene scene(camera, support::Texture(1, 0.04, 0.5));
    const auto storage = std::make_unique<support::Storage240>();
    const auto tracker = std::make_unique<FrameTracker>(FrontendConfig{}, camera, storage->view());
    FrameMeasurement out;
    std::mt19937_64 random(1);
    for (int k = 0; k < 12; ++k) {
      const auto image = scene.render(support::pose_at(0.03 * k, 0.01 * k, -1, {0, 0, 0.1 * k}),
                                      180, 30, 2.0, random);
      FrameView frame;
      frame.image = image.view();
      const auto turned = so3::exp({0, 0, 0.1});
      const std::size_t before = support::allocations();
      REQUIRE(tracker->track(frame, Timestamp{k * 50'000}, turned, out));
      CHECK(support::allocations() == before);
      CHECK(out.points.size() > 60);
    }
  }
}

}  // namespace pled
