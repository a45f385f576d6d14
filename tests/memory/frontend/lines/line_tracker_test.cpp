#include "pled_vins/frontend/lines/line_tracker.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <vector>

#include <malloc.h>

#include <doctest/doctest.h>

#include "support/frontend/drawn_edges.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PLED_COUNTS_ALLOCATIONS 0
#else
#define PLED_COUNTS_ALLOCATIONS 1
#endif

namespace {
std::size_t allocations = 0;
std::size_t live_bytes = 0;
std::size_t peak_bytes = 0;
}  // namespace

#if PLED_COUNTS_ALLOCATIONS
namespace {
void* counted(void* p) {
  if (p == nullptr) return p;
  ++allocations;
  live_bytes += malloc_usable_size(p);
  peak_bytes = std::max(peak_bytes, live_bytes);
  return p;
}
}  // namespace

// Every way to the heap goes through these in glibc, operator new and OpenCV's own included.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* p);

void* malloc(std::size_t size) { return counted(__libc_malloc(size)); }
void* calloc(std::size_t count, std::size_t size) { return counted(__libc_calloc(count, size)); }
void* realloc(void* old, std::size_t size) {
  if (old != nullptr) live_bytes -= malloc_usable_size(old);
  return counted(__libc_realloc(old, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return counted(__libc_memalign(alignment, size));
}
void* memalign(std::size_t alignment, std::size_t size) {
  return counted(__libc_memalign(alignment, size));
}
int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  *out = counted(__libc_memalign(alignment, size));
  return *out == nullptr ? ENOMEM : 0;
}
void free(void* p) {
  if (p != nullptr) live_bytes -= malloc_usable_size(p);
  __libc_free(p);
}
}
#endif

namespace pled {
namespace {

using Storage = LineStorage<240, 180>;

support::GreyImage stripes(double shift_px, double period_px) {
  return support::draw(240, 180, [&](double x, double y) {
    return std::fmod(y + 0.05 * x + 80.0 - shift_px, period_px) < 0.5 * period_px ? 200.0 : 50.0;
  });
}

}  // namespace

TEST_SUITE("frontend.line_tracker.memory") {
  TEST_CASE("track() goes to the heap as often as OpenCV's detector, and gives all back") {
    if (PLED_COUNTS_ALLOCATIONS == 0) {
      MESSAGE("skipped: the sanitizer owns the heap");
      return;
    }
    const std::size_t start = allocations;
    std::free(std::malloc(1));
    REQUIRE(allocations > start);  // the hook works

    const Camera camera = support::plain_camera(240, 180);
    const auto storage = std::make_unique<Storage>();
    const auto tracker = std::make_unique<LineTracker>(LineConfig{}, camera, storage->view());
    const auto own = std::make_unique<Storage>();
    LineFrame out;
    std::vector<ShrunkPiece> pieces(limits::kMaxSegments);
    std::size_t most_bytes = 0;
    for (int k = 0; k < 8; ++k) {
      CAPTURE(k);
      const auto image = stripes(0.5 * k, 10.0);
      FrameView frame;
      frame.image = image.view();
      const ImageView<std::uint8_t> shrunk{own->shrunk.data(), shrunk_px(240), shrunk_px(180),
                                           shrunk_px(240)};
      shrink(frame.image, own->row, shrunk);
      std::size_t found = 0;
      const std::size_t before_lsd = allocations;
      REQUIRE(find_pieces(shrunk, kLineScale * 22.5 / 3.0, pieces, found));
      const std::size_t by_lsd = allocations - before_lsd;

      const std::size_t before = allocations;
      const std::size_t live = live_bytes;
      peak_bytes = live_bytes;
      REQUIRE(tracker->track(frame, Timestamp{k * 50'000}, Eigen::Quaterniond::Identity(), out));
      CHECK(out.lines.size() >= 20);
      if (k == 0) continue;  // OpenCV sets itself up once
      CHECK(allocations - before == by_lsd);
      CHECK(live_bytes == live);
      most_bytes = std::max(most_bytes, peak_bytes - live);
    }
    const double per_pixel = static_cast<double>(most_bytes) / (shrunk_px(240) * shrunk_px(180));
    MESSAGE("OpenCV's detector: at most " << most_bytes << " bytes at once, " << per_pixel
                                          << " a pixel of the shrunk picture");
    CHECK(per_pixel < 64.0);
    MESSAGE("LineTracker " << sizeof(LineTracker) << " bytes, LineStorage<240, 180> "
                           << sizeof(Storage));
  }
}

}  // namespace pled
