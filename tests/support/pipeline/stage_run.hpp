#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pled_vins/pipeline/event_stage.hpp"
#include "support/pipeline/event_scene.hpp"

namespace pled::support {

/// An event camera of 160 x 120 pixels.
[[nodiscard]] inline RigCalibration event_rig(bool distorted) {
  RigCalibration rig;
  rig.num_cameras = 1;
  CameraCalibration& c = rig.cameras[0];
  c.width_px = 160;
  c.height_px = 120;
  c.fx_px = 131.0;
  c.fy_px = 130.0;
  c.cx_px = 82.0;
  c.cy_px = 58.5;
  if (distorted) {
    c.distortion = Distortion::kRadtan;
    c.coeffs = {-0.32, 0.11, 0.0004, -0.0006, 0.0};
  }
  return rig;
}

using EventStorage = EventStageStorage<160, 120>;

/// An event stage with its memory, and the inertial data of a swinging body.
class StageRun {
 public:
  struct Options {
    bool gyro = true;
    std::int64_t offset_us = 0;  ///< added to every time; the body's motion is as at offset 0
    std::size_t packet = 0;      ///< events a call; 0: all up to an observation at once
    bool gyro_by_packet =
        false;  ///< comes only as far as a packet needs it, not to the observation
  };

  StageRun(const EventStageConfig& config, const RigCalibration& rig, const SwingingBody& body,
           const Options& options)
      : rig_(rig),
        body_(body),
        options_(options),
        storage_(std::make_unique<EventStorage>()),
        stage_(std::make_unique<EventStage>(config, rig_, poisoned(*storage_).view())),
        imu_(std::make_unique<ImuHistory>()) {}
  StageRun(const EventStageConfig& config, const RigCalibration& rig, const SwingingBody& body)
      : StageRun(config, rig, body, Options{}) {}

  [[nodiscard]] EventStage& stage() { return *stage_; }
  [[nodiscard]] const FrameMeasurement& measured() const { return measured_; }
  [[nodiscard]] const std::vector<std::size_t>& found() const { return found_; }

  /// Observes at `t_us` (time of the body's motion) after the events up to it, which have stamps of
  /// the event camera's clock at offset 0.
  void observe(std::int64_t t_us, std::span<const Event> events) {
    const Timestamp t{t_us + options_.offset_us};
    if (!options_.gyro_by_packet) know_turn_until(t_us);
    stage_->expect(t);
    std::vector<Event> moved(events.begin(), events.end());
    for (Event& e : moved) e.t.us += options_.offset_us;
    const std::size_t packet = options_.packet == 0 ? moved.size() : options_.packet;
    for (std::size_t i = 0; i < moved.size(); i += packet) {
      const std::size_t n = std::min(packet, moved.size() - i);
      if (options_.gyro_by_packet)
        know_turn_until(events[i + n - 1].t.us + stage_->time_shift().us);
      stage_->on_events(std::span(moved).subspan(i, n));
    }
    know_turn_until(t_us);
    std::optional<Eigen::Quaterniond> R_prev_cur;
    if (last_us_) R_prev_cur = pose(*last_us_).q.conjugate() * pose(t_us).q;
    stage_->observe(t, t.us * 1000, R_prev_cur, measured_);
    last_us_ = t_us;
  }

  /// Observes every `period_us` over (from, to], each with its share of `events`.
  void play(std::span<const Event> events, std::int64_t from_us, std::int64_t to_us,
            std::int64_t period_us = 50'000) {
    const std::int64_t shift_us = stage_->time_shift().us;
    for (std::int64_t t = from_us + period_us; t <= to_us; t += period_us) {
      const auto end = std::find_if(events.begin(), events.end(),
                                    [&](const Event& e) { return e.t.us + shift_us > t; });
      const auto n = static_cast<std::size_t>(end - events.begin());
      observe(t, events.first(n));
      events = events.subspan(n);
      found_.push_back(measured_.points.size());
      history_.push_back(measured_);
      times_us_.push_back(t);
    }
  }

  /// Distances (px, sorted) between where points were seen and where the scene's motion takes them
  /// from the observation before.
  [[nodiscard]] std::vector<double> steps_off_px(const EventScene& scene) const {
    std::vector<double> errors;
    for (std::size_t k = 1; k < history_.size(); ++k)
      for (const PointMeasurement& p : history_[k].points)
        for (const PointMeasurement& was : history_[k - 1].points) {
          if (was.id != p.id) continue;
          const auto want = scene.transfer({was.raw_px[0], was.raw_px[1]}, pose(times_us_[k - 1]),
                                           pose(times_us_[k]));
          const Eigen::Vector2d at(p.raw_px[0], p.raw_px[1]);
          errors.push_back(want ? (at - *want).norm() : 1e9);
        }
    std::sort(errors.begin(), errors.end());
    return errors;
  }
  [[nodiscard]] const std::vector<FrameMeasurement>& history() const { return history_; }
  [[nodiscard]] Pose pose(std::int64_t t_us) const {
    return body_.pose(static_cast<double>(t_us) * 1e-6);
  }

 private:
  static EventStorage& poisoned(EventStorage& storage) {
    std::memset(static_cast<void*>(&storage), 0xA5, sizeof storage);
    return storage;
  }

  void know_turn_until(std::int64_t t_us) {
    feed_gyro(t_us);
    if (options_.gyro) stage_->follow_turn(*imu_, Eigen::Vector3d::Zero());
  }

  /// Samples every 4 ms, one of them after `t_us`.
  void feed_gyro(std::int64_t t_us) {
    constexpr std::int64_t kPeriod_us = 4096;
    if (next_sample_us_ == 0) next_sample_us_ = t_us - 200 * kPeriod_us;
    for (; next_sample_us_ - kPeriod_us <= t_us; next_sample_us_ += kPeriod_us) {
      const Eigen::Vector3d w = body_.gyro_radps(static_cast<double>(next_sample_us_) * 1e-6);
      (void)imu_->add(
          {{next_sample_us_ + options_.offset_us}, {w.x(), w.y(), w.z()}, {0.0, 0.0, 9.81}});
    }
  }

  RigCalibration rig_;
  SwingingBody body_;
  Options options_;
  std::unique_ptr<EventStorage> storage_;
  std::unique_ptr<EventStage> stage_;
  std::unique_ptr<ImuHistory> imu_;
  FrameMeasurement measured_;
  std::optional<std::int64_t> last_us_;
  std::int64_t next_sample_us_ = 0;
  std::vector<std::size_t> found_;
  std::vector<FrameMeasurement> history_;
  std::vector<std::int64_t> times_us_;
};

}  // namespace pled::support
