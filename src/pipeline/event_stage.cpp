#include "pled_vins/pipeline/event_stage.hpp"

#include <algorithm>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

/// A turn that covers any time and changes nothing.
constexpr int kLongSliceLog2_us = 40;

TurnSlices no_turn(Timestamp t) noexcept {
  TurnSlices slices;
  slices.t_ref = t;
  slices.length_log2_us = kLongSliceLog2_us;
  slices.begin_us = ((t.us >> kLongSliceLog2_us) - 1) << kLongSliceLog2_us;
  slices.count = 2;
  for (std::size_t i = 0; i < slices.count; ++i)
    slices.R_ref_slice[i] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  return slices;
}

UndistortionTable make_table(const Camera& camera, std::span<float> bearings) noexcept {
  UndistortionTable table;
  PLED_CHECK(table.build(camera, bearings));
  return table;
}

EventWarp make_warp(const UndistortionTable& table, const CameraCalibration& grid) noexcept {
  EventWarp warp;
  PLED_CHECK(warp.build(table, grid));
  return warp;
}

EventPictureKinds kinds_of(const EventStageConfig& config) noexcept {
  EventPictureKinds kinds;
  if (config.events.max_points > 0) kinds.add(config.events.picture);
  if (config.line_picture) kinds.add(*config.line_picture);
  return kinds;
}

}  // namespace

EventStage::EventStage(const EventStageConfig& config, const RigCalibration& rig,
                       const EventStageBuffers& buffers) noexcept
    : config_(config),
      camera_(rig.cameras[rig.event_camera]),
      R_body_cam_(rig.cameras[rig.event_camera].T_body_cam.q),
      shift_(Duration::from_s(rig.cameras[rig.event_camera].time_shift_s)),
      table_(make_table(camera_, buffers.bearings)),
      warp_(make_warp(table_, rectified(camera_.calibration()))),
      map_warp_(make_warp(table_, rectified(camera_.calibration(), limits::kMapMargin_px))),
      limit_(config.events.max_rate_mevps),
      pictures_(config.events, camera_, warp_, kinds_of(config), buffers.pictures),
      points_(config.events, config.tracking, camera_, rig.event_camera, warp_, buffers.tracker),
      scores_(config.reliability, map_warp_,
              rectified(camera_.calibration(), limits::kMapMargin_px), buffers.map) {}

void EventStage::follow_turn(const ImuHistory& imu,
                             const Eigen::Vector3d& gyro_bias_radps) noexcept {
  // Turning is kept on the events' clock, where it is used.
  std::size_t first = imu.size();
  while (first > 0 && imu[first - 1].t > turned_until_) --first;
  for (std::size_t i = first; i < imu.size(); ++i) {
    ImuSample sample = imu[i];
    turned_until_ = sample.t;
    sample.t = sample.t - shift_;
    (void)turn_.extend({&sample, 1}, gyro_bias_radps, R_body_cam_);
  }
}

void EventStage::expect(Timestamp t) noexcept {
  if (config_.keep_map) scores_.expect(t - shift_);
}

void EventStage::on_events(std::span<const Event> events) noexcept {
  limit_.pass(events, [this](std::span<const Event> passed) {
    while (!passed.empty()) {
      const std::span<const Event> run = passed.first(std::min(passed.size(), EventPictures::kRun));
      take(run);
      passed = passed.subspan(run.size());
    }
  });
}

/// Pictures and map get the same events: a hot pixel would look like something that moves.
void EventStage::take(std::span<const Event> run) noexcept {
  if (config_.events.max_points == 0 && !config_.line_picture && !config_.keep_map) return;
  const std::span<const EventVerdict> verdicts = pictures_.on_events(run);
  if (!config_.keep_map) return;
  std::size_t n = 0;
  for (std::size_t i = 0; i < run.size(); ++i)
    if (verdicts[i] != EventVerdict::kHot && verdicts[i] != EventVerdict::kDropped)
      for_map_[n++] = run[i];
  scores_.on_events(std::span(for_map_).first(n), turn_);
}

void EventStage::take_slices(Timestamp t_event) noexcept {
  if (pictures_.reach() <= Duration{}) {
    slices_.t_ref = t_event;
    slices_.count = 0;
    return;
  }
  const std::optional<Timestamp> oldest = turn_.oldest();
  const std::optional<Timestamp> newest = turn_.newest();
  if (oldest && newest && *oldest < t_event) {
    // The gyro may end a little before the frame; what is older than it knows is not drawn.
    const Timestamp to = std::min(t_event, *newest);
    const Timestamp from = std::max(t_event - pictures_.reach(), *oldest);
    if (t_event - to <= Duration{TurnHistory::kMaxStep_us} && from <= to &&
        turn_.slices(to, from, to, warp_.slice_error_rad(), slices_))
      return;
  }
  ++still_pictures_;
  slices_ = no_turn(t_event);
}

void EventStage::observe(Timestamp t, std::int64_t stamp_ns,
                         const std::optional<Eigen::Quaterniond>& R_prev_cur_body,
                         FrameMeasurement& out) noexcept {
  const Timestamp t_event = t - shift_;
  observed_ = t_event;
  take_slices(t_event);
  std::optional<Eigen::Quaterniond> R_prev_cur_cam;
  if (R_prev_cur_body) R_prev_cur_cam = R_body_cam_.conjugate() * *R_prev_cur_body * R_body_cam_;
  if (config_.events.max_points > 0) {
    pictures_.draw(points_.kind(), slices_, t_event);
    points_.observe(pictures_, slices_, t_event, t, stamp_ns, R_prev_cur_cam, out);
  } else {
    out = {};
  }
  if (config_.keep_map) scores_.observe(t_event);
}

ImageView<const std::uint8_t> EventStage::line_picture() noexcept {
  if (!config_.line_picture) return {};
  const EventPicture kind = *config_.line_picture;
  const bool is_drawn = config_.events.max_points > 0 && kind == points_.kind();
  if (!is_drawn) pictures_.draw(kind, slices_, observed_);
  return pictures_.picture(kind);
}

std::optional<PixelScore> EventStage::score(const Eigen::Vector3d& ray_cam, ScorePooling pooling,
                                            ScoreForm form) const noexcept {
  if (!config_.keep_map) return std::nullopt;
  return scores_.read(ray_cam, turn_, pooling, form);
}

std::optional<Eigen::Vector2d> EventStage::map_place(
    const Eigen::Vector3d& ray_cam) const noexcept {
  if (!config_.keep_map) return std::nullopt;
  return scores_.place(ray_cam, turn_);
}

std::optional<LineBand> EventStage::line_band(const Eigen::Vector2d& start_px,
                                              const Eigen::Vector2d& end_px,
                                              ScoreForm form) const noexcept {
  if (!config_.keep_map) return std::nullopt;
  return scores_.read_band(start_px, end_px, form);
}

void EventStage::correct_clock(Duration shift) noexcept {
  shift_ = shift_ + shift;
  reset();  // the turn is kept on the events' clock
}

void EventStage::reset() noexcept {
  turn_.clear();
  turned_until_ = Timestamp{INT64_MIN};
  pictures_.reset();
  points_.reset();
  scores_.reset();
}

EventStageCounts EventStage::counts() const noexcept {
  return {pictures_.counts(), limit_.shed(),    scores_.without_turn(),
          still_pictures_,    scores_.losses(), turn_.faults()};
}

}  // namespace pled
