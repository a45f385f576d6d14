#include "pled_vins/events/event_warp.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include <doctest/doctest.h>

#include "support/events/surface_fixture.hpp"
#include "support/events/turning_camera.hpp"

namespace pled {
namespace {

CameraCalibration davis(Distortion distortion) {
  CameraCalibration c;
  c.width_px = 240;
  c.height_px = 180;
  c.fx_px = 199.1;
  c.fy_px = 198.8;
  c.cx_px = 132.2;
  c.cy_px = 110.7;
  c.distortion = distortion;
  if (distortion == Distortion::kRadtan) c.coeffs = {-0.368, 0.151, -0.0003, -0.0004, 0.0};
  return c;
}

/// A warp with its table, and slices of a known motion.
struct Fixture {
  explicit Fixture(const CameraCalibration& calibration, int margin_px = 0,
                   const support::TurningBody& motion = {})
      : camera(calibration),
        grid(rectified(calibration, margin_px)),
        bearings(UndistortionTable::floats_needed(calibration.width_px, calibration.height_px)),
        body(motion) {
    REQUIRE(table.build(camera, bearings));
    REQUIRE(warp.build(table, grid));
    turn.extend(body.samples(0, kNow_us, 1000), Eigen::Vector3d::Zero(), R_body_cam);
    REQUIRE(turn.slices({kNow_us}, {kFrom_us}, {kNow_us}, warp.slice_error_rad(), slices));
  }

  /// Where exact rotation of this very event has it, not rounded; nullopt behind the camera.
  [[nodiscard]] std::optional<Eigen::Vector2d> exact(const Event& e) const {
    const Eigen::Vector2d raw(e.x_px, e.y_px);
    const std::optional<Eigen::Vector2d> b = camera.undistort(raw);
    if (!b) return std::nullopt;
    const Eigen::Quaterniond R = body.R_a_b(kNow_us, e.t.us, R_body_cam);
    const Eigen::Vector3d p = R * b->homogeneous();
    if (!(p.z() > 0.0)) return std::nullopt;
    return Eigen::Vector2d(grid.fx_px * p.x() / p.z() + grid.cx_px,
                           grid.fy_px * p.y() / p.z() + grid.cy_px);
  }

  [[nodiscard]] std::vector<Event> events(std::size_t count, std::uint64_t seed = 1) const {
    std::mt19937_64 random(seed);
    std::vector<Event> out(count);
    for (Event& e : out)
      e = support::event_at(
          kFrom_us + static_cast<std::int64_t>(random() % (kNow_us - kFrom_us + 1)),
          static_cast<int>(random() % 240), static_cast<int>(random() % 180));
    std::sort(out.begin(), out.end(), [](const Event& a, const Event& b) { return a.t < b.t; });
    return out;
  }

  static constexpr std::int64_t kFrom_us = 150'000;
  static constexpr std::int64_t kNow_us = 200'000;

  Camera camera;
  CameraCalibration grid;
  std::vector<float> bearings;
  UndistortionTable table;
  EventWarp warp;
  support::TurningBody body;
  Eigen::Quaterniond R_body_cam = support::slanted_mount();
  TurnHistory turn;
  TurnSlices slices;
};

const WarpedPixel kPoison{12345, -12345};

}  // namespace

TEST_SUITE("events.event_warp") {
  TEST_CASE("carried points are within 0.1 px of exact rotation for each event, at 5 rad/s") {
    support::TurningBody fast;
    fast.steady_radps = 4.0;
    fast.swing_rad = 0.05;
    const auto f = std::make_unique<Fixture>(davis(Distortion::kRadtan), 0, fast);
    double fastest_radps = 0.0;
    for (std::int64_t t = Fixture::kFrom_us; t <= Fixture::kNow_us; t += 1000)
      fastest_radps =
          std::max(fastest_radps, fast.gyro_radps(static_cast<double>(t) * 1e-6).norm());
    REQUIRE(fastest_radps > 5.0);
    double worst = 0.0;
    double squares = 0.0;
    std::size_t n = 0;
    for (const Event& e : f->events(20'000)) {
      const std::optional<Eigen::Vector2d> want = f->exact(e);
      const std::optional<Eigen::Vector2f> got =
          f->warp.carry({static_cast<float>(e.x_px), static_cast<float>(e.y_px)}, e.t, f->slices);
      if (!want || !got) continue;
      const double error = (got->cast<double>() - *want).norm();
      worst = std::max(worst, error);
      squares += error * error;
      ++n;
    }
    const double rms = std::sqrt(squares / static_cast<double>(n));
    MESSAGE("up to " << fastest_radps << " rad/s, f = 199 px, slices of "
                     << (1 << f->slices.length_log2_us) << " us: error rms " << rms << " px, max "
                     << worst << " px over " << n << " events");
    CHECK(n > 10'000);
    CHECK(rms < 0.05);
    CHECK(worst < 0.1);
  }

  TEST_CASE("the pixel is the carried point rounded, or outside when that misses the grid") {
    for (const Distortion distortion : {Distortion::kNone, Distortion::kRadtan}) {
      for (const int margin_px : {0, 7}) {
        const auto f = std::make_unique<Fixture>(davis(distortion), margin_px);
        const std::vector<Event> events = f->events(20'003);
        std::vector<WarpedPixel> out(events.size(), kPoison);
        f->warp.warp(events, f->slices, out);
        std::size_t inside = 0;
        for (std::size_t i = 0; i < events.size(); ++i) {
          const std::optional<Eigen::Vector2d> want = f->exact(events[i]);
          REQUIRE(want);
          const double beyond = std::max({-0.5 - want->x(), want->x() - f->grid.width_px + 0.5,
                                          -0.5 - want->y(), want->y() - f->grid.height_px + 0.5});
          if (out[i] == kOutsideGrid) {
            REQUIRE(beyond > -0.1);
            continue;
          }
          ++inside;
          REQUIRE(beyond < 0.1);
          REQUIRE(std::abs(out[i].x_px - want->x()) < 0.6);
          REQUIRE(std::abs(out[i].y_px - want->y()) < 0.6);
        }
        CHECK(inside > 10'000);
        CHECK(inside < events.size());
      }
    }
  }

  TEST_CASE("four at a time gives the pixels of one at a time, in any packets") {
    const auto f = std::make_unique<Fixture>(davis(Distortion::kRadtan));
    const std::vector<Event> events = f->events(10'001);
    std::vector<WarpedPixel> whole(events.size(), kPoison);
    f->warp.warp(events, f->slices, whole);
    for (std::size_t i = 0; i < events.size(); ++i) {
      const std::size_t pixel = events[i].y_px * std::size_t{240} + events[i].x_px;
      const std::optional<Eigen::Vector2f> at =
          f->warp.carry_pixel(pixel, f->slices, f->slices.index(events[i].t.us));
      WarpedPixel want = kOutsideGrid;
      if (at)
        want = {static_cast<std::int16_t>(std::floor(at->x() + 0.5F)),
                static_cast<std::int16_t>(std::floor(at->y() + 0.5F))};
      REQUIRE(whole[i] == want);
    }
    std::vector<WarpedPixel> split(events.size(), kPoison);
    std::size_t done = 0;
    support::in_packets(5, events, [&](std::span<const Event> packet) {
      f->warp.warp(packet, f->slices, std::span(split).subspan(done, packet.size()));
      done += packet.size();
    });
    CHECK(split == whole);
  }

  TEST_CASE("a camera that does not turn leaves a pixel where it is, moved by the margin alone") {
    support::TurningBody still;
    still.steady_radps = 0.0;
    still.swing_rad = 0.0;
    const auto f = std::make_unique<Fixture>(davis(Distortion::kNone), 5, still);
    for (int y = 0; y < 180; ++y) {
      std::vector<Event> row;
      for (int x = 0; x < 240; ++x) row.push_back(support::event_at(160'000 + x, x, y));
      std::vector<WarpedPixel> out(row.size(), kPoison);
      f->warp.warp(row, f->slices, out);
      for (int x = 0; x < 240; ++x) {
        const WarpedPixel want{static_cast<std::int16_t>(x + 5), static_cast<std::int16_t>(y + 5)};
        REQUIRE(out[static_cast<std::size_t>(x)] == want);
      }
    }
  }

  TEST_CASE("what has turned behind the camera is outside, not mirrored") {
    const auto f = std::make_unique<Fixture>(davis(Distortion::kNone));
    // Half a turn: the centre's bearing has z' = -1 and would project into the picture.
    f->slices.R_ref_slice[0] = {-1, 0, 0, 0, 1, 0, 0, 0, -1};
    const std::array events{support::event_at(f->slices.begin_us, 132, 110)};
    std::array<WarpedPixel, 1> out{kPoison};
    f->warp.warp(events, f->slices, out);
    CHECK(out[0] == kOutsideGrid);
    CHECK(!f->warp.carry({132.0F, 110.0F}, events[0].t, f->slices));
  }

  TEST_CASE("off the sensor, without bearing, without slice, not finite: outside") {
    const auto f = std::make_unique<Fixture>(davis(Distortion::kNone));
    f->bearings[2 * (50 * 240 + 60)] = std::numeric_limits<float>::quiet_NaN();
    const std::int64_t begin_us = f->slices.begin_us;
    const std::int64_t end_us = f->slices.begin_of_us(f->slices.count);
    const std::array bad{support::event_at(begin_us - 1, 60, 60),
                         support::event_at(170'000, 240, 60),
                         support::event_at(170'000, 60, 180),
                         support::event_at(170'000, 65535, 65535),
                         support::event_at(170'000, 60, 50),
                         support::event_at(end_us, 60, 60),
                         support::event_at(std::numeric_limits<std::int64_t>::max(), 60, 60)};
    std::array<WarpedPixel, bad.size()> out;
    out.fill(kPoison);
    f->warp.warp(bad, f->slices, out);
    for (const WarpedPixel& p : out) CHECK(p == kOutsideGrid);
    f->slices.R_ref_slice[3].fill(std::numeric_limits<float>::quiet_NaN());
    const std::array lost{support::event_at(f->slices.begin_of_us(3), 60, 60)};
    f->warp.warp(lost, f->slices, out);
    CHECK(out[0] == kOutsideGrid);
    f->warp.warp({}, f->slices, {});
  }

  TEST_CASE("a grid that does not fit is refused and leaves the warp as it was") {
    const auto f = std::make_unique<Fixture>(davis(Distortion::kNone));
    CameraCalibration wide = f->grid;
    wide.width_px = 16385;
    CHECK(!f->warp.build(f->table, wide));
    CHECK(!f->warp.build(f->table, davis(Distortion::kRadtan)));
    CHECK(!f->warp.build(UndistortionTable{}, f->grid));
    CHECK(f->warp.width_px() == 240);
  }
}

}  // namespace pled
