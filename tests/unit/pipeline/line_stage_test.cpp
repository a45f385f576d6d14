#include "pled_vins/pipeline/line_stage.hpp"

#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <optional>
#include <set>

#include <doctest/doctest.h>

#include "support/frontend/drawn_edges.hpp"

namespace pled {
namespace {

using support::GreyImage;
using support::Rectangle;

using Storage = LineStorage<240, 180>;

/// One camera for frames and events, or one for each with the same pixels.
RigCalibration rig_of(const Camera& camera, bool one_camera = true) {
  RigCalibration rig;
  rig.cameras[0] = camera.calibration();
  rig.cameras[1] = camera.calibration();
  rig.num_cameras = one_camera ? 1 : 2;
  rig.event_camera = one_camera ? 0 : 1;
  return rig;
}

RigCalibration plain_rig(bool one_camera = true) {
  return rig_of(support::plain_camera(240, 180), one_camera);
}

LineStageConfig config_of(LineSource source, EventPicture picture = EventPicture::kBrightness) {
  LineStageConfig config;
  config.source = source;
  config.event_picture = picture;
  return config;
}

/// A stage with its memory, shown pictures 50 ms apart.
class Run {
 public:
  explicit Run(const LineStageConfig& config, const RigCalibration& rig = plain_rig())
      : stage_(std::make_unique<LineStage>(config, rig, poisoned(*storage_).view())),
        out_(std::make_unique<FrameMeasurement>()) {
    (void)out_->lines.resize(3);  // to be overwritten
  }

  const FrameMeasurement& show(const GreyImage* frame, const GreyImage* events) {
    t_us_ += 50'000;
    out_->t = Timestamp{t_us_};
    out_->stamp_ns = t_us_ * 1000;
    LinePictures pictures;
    if (frame != nullptr) pictures.frame = frame->view();
    if (events != nullptr) pictures.events = events->view();
    stage_->observe(pictures, Eigen::Quaterniond::Identity(), *out_);
    return *out_;
  }
  const FrameMeasurement& show(const GreyImage& frame, const GreyImage& events) {
    return show(&frame, &events);
  }
  [[nodiscard]] LineStage& stage() { return *stage_; }

 private:
  static Storage& poisoned(Storage& storage) {
    std::memset(static_cast<void*>(&storage), 0xA5, sizeof storage);
    return storage;
  }

  std::unique_ptr<Storage> storage_ = std::make_unique<Storage>();
  std::unique_ptr<LineStage> stage_;
  std::unique_ptr<FrameMeasurement> out_;
  std::int64_t t_us_ = 0;
};

/// Bright below a nearly level edge.
GreyImage level_edge(double y_px, double slope = 0.1) {
  return support::draw(
      240, 180, [&](double x, double y) { return y > y_px + slope * (x - 120.0) ? 180.0 : 60.0; });
}

GreyImage upright_edge(double x_px) {
  return support::draw(240, 180, [&](double x, double) { return x > x_px ? 180.0 : 60.0; });
}

GreyImage boxes(double turn_rad, double shift_px = 0.0) {
  const Rectangle box({120.0 + shift_px, 90.0}, 13.0, 13.0, turn_rad);
  return support::draw(240, 180,
                       [&](double x, double y) { return box.holds(x, y) ? 180.0 : 60.0; });
}

GreyImage stripes(double period_px, bool level) {
  return support::draw(240, 180, [&](double x, double y) {
    const double along = level ? y + 0.03 * x : x + 0.03 * y;
    return std::fmod(along + 80.0, period_px) < 0.5 * period_px ? 200.0 : 50.0;
  });
}

GreyImage blank() {
  return support::draw(240, 180, [](double, double) { return 128.0; });
}

std::set<FeatureId> ids_of(const FrameMeasurement& m) {
  std::set<FeatureId> ids;
  for (const LineMeasurement& line : m.lines) ids.insert(line.id);
  return ids;
}

bool is_of_events(const LineMeasurement& line) { return line.id >= kFirstEventLineId; }

}  // namespace

TEST_SUITE("pipeline.line_stage") {
  TEST_CASE("lines come from the pictures that are wanted, with ids that tell which") {
    const GreyImage frame = level_edge(60);
    const GreyImage events = upright_edge(90);
    for (const LineSource source :
         {LineSource::kNone, LineSource::kFrames, LineSource::kEvents, LineSource::kBoth}) {
      CAPTURE(static_cast<int>(source));
      Run run(config_of(source), plain_rig(false));
      for (std::uint32_t k = 1; k <= 3; ++k) {
        const FrameMeasurement& m = run.show(frame, events);
        std::size_t of_events = 0;
        for (const LineMeasurement& line : m.lines) {
          CHECK(line.track_length == k);
          CHECK(line.camera == (is_of_events(line) ? 1 : 0));
          const double across_px =
              is_of_events(line) ? line.raw_px[0][0] - 90.0
                                 : line.raw_px[0][1] - 60.0 - 0.1 * (line.raw_px[0][0] - 120.0);
          CHECK(std::abs(across_px) < 1.0);
          of_events += is_of_events(line) ? 1U : 0U;
        }
        CHECK(of_events == (from_events(source) ? 1U : 0U));
        CHECK(m.lines.size() - of_events == (from_frames(source) ? 1U : 0U));
        CHECK(ids_of(m).size() == m.lines.size());
      }
      CHECK(run.stage().skipped() == 0);
    }
  }

  TEST_CASE("of an edge that one camera shows twice the line known for longer is taken") {
    const GreyImage nothing = blank();
    for (const bool frame_first : {true, false}) {
      CAPTURE(frame_first);
      Run run(config_of(LineSource::kBoth));
      const GreyImage frame = level_edge(60);
      const GreyImage events = level_edge(61.2);
      FeatureId first = 0;
      for (int k = 0; k < 3; ++k) {
        const FrameMeasurement& m =
            frame_first ? run.show(frame, nothing) : run.show(nothing, events);
        REQUIRE(m.lines.size() == 1);
        first = m.lines[0].id;
      }
      CHECK((first >= kFirstEventLineId) == !frame_first);
      for (std::uint32_t k = 4; k < 7; ++k) {
        const FrameMeasurement& m = run.show(frame, events);
        REQUIRE(m.lines.size() == 1);
        CHECK(m.lines[0].id == first);
        CHECK(m.lines[0].track_length == k);
      }
    }
    Run run(config_of(LineSource::kBoth));
    const FrameMeasurement& m = run.show(level_edge(60), level_edge(61.2));
    REQUIRE(m.lines.size() == 1);  // of two as old that of the frame
    CHECK_FALSE(is_of_events(m.lines[0]));
  }

  TEST_CASE("lines 3 px or 5 degrees apart, or of two cameras, are both given out") {
    constexpr double kTurn_rad = 5.0 * std::numbers::pi / 180.0;
    Run beside(config_of(LineSource::kBoth));
    CHECK(beside.show(level_edge(60), level_edge(63)).lines.size() == 2);
    Run turned(config_of(LineSource::kBoth));
    CHECK(turned.show(boxes(0.2), boxes(0.2 + kTurn_rad)).lines.size() == 8);
    Run alike(config_of(LineSource::kBoth));
    CHECK(alike.show(boxes(0.2), boxes(0.2 + 0.2 * kTurn_rad)).lines.size() == 4);
    Run two_cameras(config_of(LineSource::kBoth), plain_rig(false));
    CHECK(two_cameras.show(boxes(0.2), boxes(0.2)).lines.size() == 8);
  }

  TEST_CASE("the bright side does not matter to whether two lines are one edge") {
    Run run(config_of(LineSource::kBoth));
    GreyImage negative = level_edge(60);
    for (std::uint8_t& grey : negative.pixels) grey = static_cast<std::uint8_t>(255 - grey);
    CHECK(run.show(level_edge(60), negative).lines.size() == 1);
  }

  TEST_CASE("lines of a time surface have the pixels of the sensor, lens included") {
    const Camera camera = support::davis240_camera(true);
    Run run(config_of(LineSource::kEvents, EventPicture::kTimeSurface), rig_of(camera));
    const double front_px = 60.0;
    const GreyImage surface = support::draw(240, 180, [&](double x, double) {
      return x < front_px ? 128.0 + 127.0 * std::exp((x - front_px) / 12.0) : 128.0;
    });
    const FrameMeasurement& m = run.show(surface, surface);
    REQUIRE(m.lines.size() == 1);
    const LineMeasurement& line = m.lines[0];
    const CameraCalibration& c = camera.calibration();
    for (std::size_t k = 0; k < 2; ++k) {
      CHECK(std::abs(c.fx_px * line.bearing_xy[k][0] + c.cx_px - front_px) < 1.0);
      const auto bearing = camera.undistort({line.raw_px[k][0], line.raw_px[k][1]});
      REQUIRE(bearing.has_value());
      CHECK(std::abs(bearing->x() - line.bearing_xy[k][0]) < 1e-6);
      CHECK(std::abs(bearing->y() - line.bearing_xy[k][1]) < 1e-6);
    }
  }

  TEST_CASE("pictures without an edge give no lines, thousands of stripes no more than fit") {
    Run run(config_of(LineSource::kBoth));
    CHECK(run.show(blank(), blank()).lines.empty());
    const GreyImage level = stripes(8.0, true);
    const GreyImage upright = stripes(8.0, false);
    for (int k = 0; k < 4; ++k) {
      const FrameMeasurement& m = run.show(level, upright);
      CHECK(m.lines.size() == limits::kMaxLines);
      CHECK(ids_of(m).size() == m.lines.size());
      for (std::size_t i = 1; i < m.lines.size(); ++i)
        CHECK(m.lines[i].track_length <= m.lines[i - 1].track_length);
    }
    CHECK(run.show(blank(), blank()).lines.empty());
  }

  TEST_CASE("a picture of a wrong size is counted, gives no lines and ends the tracks") {
    Run run(config_of(LineSource::kFrames));
    const GreyImage image = level_edge(60);
    const FeatureId id = run.show(&image, nullptr).lines[0].id;
    const GreyImage small(120, 90);
    CHECK(run.show(&small, nullptr).lines.empty());
    CHECK(run.stage().skipped() == 1);
    const FrameMeasurement& after = run.show(&image, nullptr);
    REQUIRE(after.lines.size() == 1);
    CHECK(after.lines[0].id != id);
    CHECK(after.lines[0].track_length == 1);
  }

  TEST_CASE("no picture gives no lines, and is no fault") {
    Run run(config_of(LineSource::kBoth));
    CHECK(run.show(nullptr, nullptr).lines.empty());
    CHECK(run.stage().skipped() == 0);
    const GreyImage image = level_edge(60);
    CHECK(run.show(nullptr, &image).lines.size() == 1);
  }

  TEST_CASE("after a reset all lines are new, after one of the events only theirs") {
    const GreyImage frame = level_edge(60);
    const GreyImage events = upright_edge(90);
    for (const bool all : {true, false}) {
      CAPTURE(all);
      Run run(config_of(LineSource::kBoth));
      (void)run.show(frame, events);
      const std::set<FeatureId> before = ids_of(run.show(frame, events));
      REQUIRE(before.size() == 2);
      if (all)
        run.stage().reset();
      else
        run.stage().reset_events();
      const FrameMeasurement& m = run.show(frame, events);
      REQUIRE(m.lines.size() == 2);
      for (const LineMeasurement& line : m.lines) {
        const bool stays = !all && !is_of_events(line);
        CHECK(before.count(line.id) == (stays ? 1U : 0U));
        CHECK(line.track_length == (stays ? 3U : 1U));
      }
    }
  }

  TEST_CASE("a clock that is set right changes no rate of its own lines") {
    const double step_px = 2.0;
    for (const bool of_events : {true, false}) {
      CAPTURE(of_events);
      Run run(config_of(of_events ? LineSource::kEvents : LineSource::kFrames));
      const auto show = [&](double y) -> const FrameMeasurement& {
        const GreyImage image = level_edge(y, 0.0);
        return run.show(image, image);
      };
      (void)show(60.0);
      (void)show(60.0 + step_px);
      // The next picture comes after 50 ms; set forward by 25 the last was 25 ms before it.
      of_events ? run.stage().shift_events(Duration::from_ms(25))
                : run.stage().shift_frames(Duration::from_ms(25));
      const FrameMeasurement& m = show(60.0 + 2 * step_px);
      REQUIRE(m.lines.size() == 1);
      CHECK(m.lines[0].track_length == 3);
      const double want_ps = step_px / 200.0 / 0.025;
      CHECK(m.lines[0].bearing_rate_xyps[0][1] == doctest::Approx(want_ps).epsilon(0.15));
    }
  }

  TEST_CASE("a camera too small for lines shows none") {
    CameraCalibration tiny = support::plain_camera(12, 10).calibration();
    Run run(config_of(LineSource::kBoth), rig_of(Camera(tiny)));
    const GreyImage image(12, 10);
    CHECK(run.show(image, image).lines.empty());
    CHECK(run.stage().skipped() == 0);
  }

  TEST_CASE("of what is not looked at nothing is left of a source") {
    using enum LineSource;
    CHECK(narrowed(kBoth, true, true) == kBoth);
    CHECK(narrowed(kBoth, true, false) == kFrames);
    CHECK(narrowed(kBoth, false, true) == kEvents);
    CHECK(narrowed(kEvents, true, false) == kNone);
    CHECK(narrowed(kFrames, false, true) == kNone);
    CHECK(narrowed(kNone, true, true) == kNone);
    CHECK(narrowed(kFrames, true, true) == kFrames);
    CHECK(narrowed(kEvents, true, true) == kEvents);
  }
}

}  // namespace pled
