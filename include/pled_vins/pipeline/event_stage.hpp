#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Geometry>

#include "pled_vins/core/messages.hpp"
#include "pled_vins/events/event_warp.hpp"
#include "pled_vins/events/turn_history.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/geometry/undistortion_table.hpp"
#include "pled_vins/imu/imu_history.hpp"
#include "pled_vins/pipeline/event_pictures.hpp"
#include "pled_vins/pipeline/event_points.hpp"
#include "pled_vins/pipeline/event_scores.hpp"
#include "pled_vins/pipeline/rate_limit.hpp"

namespace pled {

/// The memory of an EventStage, whatever the sensor's size.
struct EventStageBuffers {
  std::span<float> bearings;  ///< UndistortionTable::floats_needed
  EventPictureBuffers pictures;
  FrameTrackerBuffers tracker;  ///< without those for finding corners
  AnchoredMapBuffers map;
};

/// The same as arrays, for sensors up to MaxWidth x MaxHeight pixels. Plain data, no constructor.
template <int MaxWidth, int MaxHeight>
struct EventStageStorage {
  static constexpr std::size_t kPixels =
      static_cast<std::size_t>(MaxWidth) * static_cast<std::size_t>(MaxHeight);

  std::array<float, 2 * kPixels> bearings;
  std::array<SurfacePixel, kPixels> pixels;
  // Points and lines may be looked for in pictures of two kinds.
  std::array<BrightnessPixel, kPixels> brightness;
  std::array<float, TimeSurface::floats_needed(MaxWidth, MaxHeight)> drawing;
  std::array<std::uint8_t, kPixels> brightness_picture;
  std::array<std::uint8_t, kPixels> surface_picture;
  std::array<std::array<std::int16_t, pyramid_values(MaxWidth, MaxHeight)>, 2> pyramids;
  std::array<std::uint16_t, static_cast<std::size_t>(padded_stride(MaxWidth))> row;
  std::array<std::int16_t, ReferencePatches::kValues> reference_patches;
  AnchoredMapStorage<MaxWidth, MaxHeight> map;

  [[nodiscard]] EventStageBuffers view() noexcept {
    FrameTrackerBuffers tracker;
    tracker.max_width_px = MaxWidth;
    tracker.max_height_px = MaxHeight;
    tracker.pyramids = {pyramids[0], pyramids[1]};
    tracker.row = row;
    tracker.reference_patches = reference_patches;
    return {bearings,
            {pixels, brightness, drawing, brightness_picture, surface_picture},
            tracker,
            map.view()};
  }
};

/// What the event stage is to do.
struct EventStageConfig {
  EventConfig events;
  FrontendConfig tracking;
  ReliabilityConfig reliability;
  bool keep_map = false;  ///< feed the entropy-recency map: somebody reads it
  /// What lines are looked for in; nullopt: not in events.
  std::optional<EventPicture> line_picture;
};

/// What became of the events, since the start.
struct EventStageCounts {
  SurfaceCounts surface;
  std::uint64_t shed = 0;            ///< beyond the rate limit
  std::uint64_t without_turn = 0;    ///< not in the map: nobody knew how the camera turned
  std::uint64_t still_pictures = 0;  ///< observations drawn without compensation, for the same
  BinCounterLosses map;              ///< lost in the map
  TurnFaults turn;                   ///< what was wrong with the gyro's samples
};

/// Everything that is done with events: compensation for the camera's turning, points, and the
/// entropy-recency map. Events come in time order up to an observation, then the observation. The
/// gyro's samples up to an instant are to be in the history before its events come.
class EventStage {
 public:
  /// @param rig  the event camera and its clock; nothing is owned, all outlives this object
  EventStage(const EventStageConfig& config, const RigCalibration& rig,
             const EventStageBuffers& buffers) noexcept;

  /// Learns from the inertial history how the camera has turned.
  void follow_turn(const ImuHistory& imu, const Eigen::Vector3d& gyro_bias_radps) noexcept;
  /// Says when the next observation will be, on the estimator clock, before its events come.
  void expect(Timestamp t) noexcept;
  void on_events(std::span<const Event> events) noexcept;
  /// Points at an observation; `out` is written whole.
  /// @param t  estimator clock
  /// @param R_prev_cur_body  body now to body at the last observation, nullopt: unknown
  void observe(Timestamp t, std::int64_t stamp_ns,
               const std::optional<Eigen::Quaterniond>& R_prev_cur_body,
               FrameMeasurement& out) noexcept;

  /// The entropy-recency score at a ray of the event camera, at the last observation. nullopt: no
  /// evidence, or no map is kept.
  [[nodiscard]] std::optional<PixelScore> score(const Eigen::Vector3d& ray_cam,
                                                ScorePooling pooling,
                                                ScoreForm form) const noexcept;

  /// The pixel of the map where a ray of the event camera falls at the last observation, and what
  /// the map says along a line between two such. nullopt: as of EventScores, or no map is kept.
  [[nodiscard]] std::optional<Eigen::Vector2d> map_place(
      const Eigen::Vector3d& ray_cam) const noexcept;
  [[nodiscard]] std::optional<LineBand> line_band(const Eigen::Vector2d& start_px,
                                                  const Eigen::Vector2d& end_px,
                                                  ScoreForm form) const noexcept;

  /// Says that the times of observations given so far were early by `shift`.
  void shift_clock(Duration shift) noexcept { points_.shift_clock(shift); }
  /// Says that event stamps are early by so much more than time_shift() tells, which it tells from
  /// here on. What was seen is forgotten: it was put where the camera had not yet turned to.
  void correct_clock(Duration shift) noexcept;
  /// Another clock stamps everything from here on.
  void reset() noexcept;

  /// Event stamps plus this are on the estimator clock.
  [[nodiscard]] Duration time_shift() const noexcept { return shift_; }
  /// The picture of the last observation that points are followed in.
  [[nodiscard]] ImageView<const std::uint8_t> picture() const noexcept {
    return pictures_.picture(points_.kind());
  }
  /// The one that lines are looked for in (config.line_picture); drawn now where it is another. To
  /// be called after observe(), before more events. Empty without lines.
  [[nodiscard]] ImageView<const std::uint8_t> line_picture() noexcept;
  [[nodiscard]] EventStageCounts counts() const noexcept;

 private:
  void take(std::span<const Event> run) noexcept;
  void take_slices(Timestamp t_event) noexcept;

  EventStageConfig config_;
  Camera camera_;
  Eigen::Quaterniond R_body_cam_;
  Duration shift_;
  UndistortionTable table_;
  EventWarp warp_;      ///< to the rectified picture
  EventWarp map_warp_;  ///< the same with the map's margin
  TurnHistory turn_;
  TurnSlices slices_;
  Timestamp turned_until_{INT64_MIN};
  Timestamp observed_;  ///< last observation, event camera's clock
  RateLimit limit_;
  EventPictures pictures_;
  EventPoints points_;
  EventScores scores_;
  std::array<Event, EventPictures::kRun> for_map_{};
  std::uint64_t still_pictures_ = 0;
};

}  // namespace pled
