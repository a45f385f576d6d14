#include <cstddef>
#include <cstdlib>

#include <doctest/doctest.h>

#include "support/frontend/tracked_scene.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PLED_COUNTS_ALLOCATIONS 0
#else
#define PLED_COUNTS_ALLOCATIONS 1
#endif

namespace {
std::size_t allocations = 0;
}

#if PLED_COUNTS_ALLOCATIONS
// Every way to the heap goes through these in glibc, operator new included.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
}
#endif

namespace pled {

TEST_SUITE("frontend.frame_tracker.memory") {
  TEST_CASE("track() never goes to the heap") {
    if (PLED_COUNTS_ALLOCATIONS == 0) {
      MESSAGE("skipped: the sanitizer owns the heap");
      return;
    }
    const std::size_t start = allocations;
    std::free(std::malloc(1));
    REQUIRE(allocations > start);  // the hook works

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
      const std::size_t before = allocations;
      REQUIRE(tracker->track(frame, Timestamp{k * 50'000}, turned, out));
      CHECK(allocations == before);
      CHECK(out.points.size() > 60);
    }
  }
}

}  // namespace pled
