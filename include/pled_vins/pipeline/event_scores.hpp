#pragma once

#include <array>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/events/event_warp.hpp"
#include "pled_vins/events/turn_history.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/reliability/anchored_map.hpp"
#include "pled_vins/reliability/bin_clock.hpp"
#include "pled_vins/reliability/config.hpp"
#include "pled_vins/reliability/line_band.hpp"

namespace pled {

/// Feeds the entropy-recency map with compensated events and reads it where a point is seen.
class EventScores {
 public:
  /// @param warp  to `grid`; outlives this object
  /// @param grid  rectified(camera, limits::kMapMargin_px)
  EventScores(const ReliabilityConfig& config, const EventWarp& warp, const CameraCalibration& grid,
              const AnchoredMapBuffers& buffers) noexcept;

  /// Says when the next observation will be (event camera's clock), before its events come.
  void expect(Timestamp t) noexcept;
  /// Events in time order. Those whose turning is not known are left out and counted.
  void on_events(std::span<const Event> events, const TurnHistory& turn) noexcept;
  /// Closes the window of an observation; read() is of it.
  void observe(Timestamp t) noexcept;

  /// The score where a bearing of the event camera falls at the time of the last observation.
  /// nullopt: outside, without events, or not known how the camera turned.
  [[nodiscard]] std::optional<PixelScore> read(const Eigen::Vector3d& ray_cam,
                                               const TurnHistory& turn, ScorePooling pooling,
                                               ScoreForm form) const noexcept;

  /// The pixel of the map's grid, as seen from its anchor, where a bearing of the event camera
  /// falls at the time of the last observation; nullopt when it is not known how the camera turned,
  /// or the anchor's camera had it behind.
  [[nodiscard]] std::optional<Eigen::Vector2d> place(const Eigen::Vector3d& ray_cam,
                                                     const TurnHistory& turn) const noexcept;
  /// What the map says along a line between two such pixels.
  [[nodiscard]] std::optional<LineBand> read_band(const Eigen::Vector2d& start_px,
                                                  const Eigen::Vector2d& end_px,
                                                  ScoreForm form) const noexcept {
    return read_line_band(map_, last_bin_, start_px, end_px, form);
  }

  void reset() noexcept;
  /// Events that were not counted because nobody knew how the camera had turned.
  [[nodiscard]] std::uint64_t without_turn() const noexcept { return without_turn_; }
  /// Events that the map lost, since the start.
  [[nodiscard]] BinCounterLosses losses() const noexcept;

 private:
  static constexpr std::size_t kRun = 512;

  void add_run(std::span<const Event> run, const TimeBin& bin, const TurnHistory& turn) noexcept;
  [[nodiscard]] double shift_since_anchor_px(Timestamp t, const TurnHistory& turn) const noexcept;

  const EventWarp& warp_;
  CameraCalibration grid_;
  double stretch_;  ///< pixels that the picture's corner moves in a turn of one radian, at most
  BinClock clock_;
  AnchoredMap map_;
  TurnSlices slices_;
  std::array<WarpedPixel, kRun> warped_{};
  std::optional<Timestamp> binned_;
  Timestamp observed_;
  BinNumber last_bin_ = 0;
  std::uint64_t without_turn_ = 0;
  BinCounterLosses lost_before_;  ///< the last reset
};

}  // namespace pled
