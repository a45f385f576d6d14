#include "pled_vins/frontend/lines/line_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include "support/frontend/drawn_edges.hpp"
#include "support/heap_counter.hpp"

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
    if (!support::heap_is_counted()) return;
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
      const std::size_t before_lsd = support::allocations();
      REQUIRE(find_pieces(shrunk, kLineScale * 22.5 / 3.0, pieces, found));
      const std::size_t by_lsd = support::allocations() - before_lsd;

      const std::size_t before = support::allocations();
      const std::size_t live = support::live_bytes();
      support::forget_peak();
      REQUIRE(tracker->track(frame, Timestamp{k * 50'000}, Eigen::Quaterniond::Identity(), out));
      CHECK(out.lines.size() >= 20);
      if (k == 0) continue;  // OpenCV sets itself up once
      CHECK(support::allocations() - before == by_lsd);
      CHECK(support::live_bytes() == live);
      most_bytes = std::max(most_bytes, support::peak_bytes() - live);
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
