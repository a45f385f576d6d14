#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

#include "pled_vins/core/image_view.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/frontend/lines/line_tracker.hpp"
#include "pled_vins/geometry/camera.hpp"
#include "pled_vins/pipeline/line_config.hpp"

namespace pled {

/// The pictures of one observation; empty where there is none.
struct LinePictures {
  ImageView<const std::uint8_t> frame;
  ImageView<const std::uint8_t> events;  ///< drawn as LineStageConfig::event_picture
};

/// Lines of each observation, followed through frames, through pictures drawn from events, or both.
class LineStage {
 public:
  /// A camera of fewer pixels than LineDetector::kMinSide_px a side shows no lines.
  /// @param buffers  used by both kinds in turn; they hold the pictures of either camera
  LineStage(const LineStageConfig& config, const RigCalibration& rig,
            const LineBuffers& buffers) noexcept;

  /// Fills out.lines of an observation whose time is set, longest followed first, no more than
  /// limits::kMaxLines. Of an edge that one camera shows in both pictures (3 degrees, 2 px, side by
  /// side over half of the shorter) the line that has been followed for longer is taken, of two as
  /// old the frame's. Pixels are those of the sensor.
  /// @param R_prev_cur_body  body now to body at the last observation, nullopt: unknown
  void observe(const LinePictures& pictures,
               const std::optional<Eigen::Quaterniond>& R_prev_cur_body,
               FrameMeasurement& out) noexcept;

  /// Say that the times of observations given so far were early by `shift`.
  void shift_frames(Duration shift) noexcept;
  void shift_events(Duration shift) noexcept;
  /// What was seen in events is forgotten: their clock was wrong.
  void reset_events() noexcept;
  /// Another clock stamps everything from here on.
  void reset() noexcept;

  /// Pictures of a wrong size, or for which memory ran out, since the start.
  [[nodiscard]] std::uint64_t skipped() const noexcept { return skipped_; }

 private:
  void follow(ImageView<const std::uint8_t> picture,
              const std::optional<Eigen::Quaterniond>& R_prev_cur_cam, const FrameMeasurement& at,
              LineTracker& tracker, LineFrame& out) noexcept;
  void drop_doubles() noexcept;
  [[nodiscard]] bool one_edge(const LineMeasurement& a, const LineMeasurement& b) const noexcept;
  void give_out(FrameMeasurement& out) const noexcept;

  bool one_camera_;
  bool rectified_events_;  ///< drawn without the lens
  Eigen::Quaterniond R_body_frames_;
  Eigen::Quaterniond R_body_events_;
  FlatPixels event_flat_;
  std::optional<LineTracker> frames_;
  std::optional<LineTracker> events_;
  LineFrame frame_lines_;
  LineFrame event_lines_;
  std::uint64_t skipped_ = 0;
};

}  // namespace pled
