#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pled_vins/core/fixed_vector.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/frontend/config.hpp"
#include "pled_vins/frontend/corners.hpp"
#include "pled_vins/frontend/point_follower.hpp"
#include "pled_vins/frontend/point_track.hpp"
#include "pled_vins/frontend/pyramid.hpp"
#include "pled_vins/frontend/reference_patches.hpp"
#include "pled_vins/frontend/track_motion.hpp"
#include "pled_vins/geometry/camera.hpp"

namespace pled {

/// The memory of a FrameTracker, whatever the sensor's size.
struct FrameTrackerBuffers {
  int max_width_px = 0;
  int max_height_px = 0;
  std::array<std::span<std::int16_t>, 2> pyramids;  ///< previous and current frame
  std::span<std::uint16_t> row;
  std::span<float> corner_rows;
  std::span<float> response;     ///< one per pixel
  std::span<std::uint8_t> mask;  ///< one per pixel
  std::span<Corner> corner_cells;
  std::span<std::int16_t> reference_patches;
};

/// The same as arrays, for images up to MaxWidth x MaxHeight pixels. Plain data, no constructor.
template <int MaxWidth, int MaxHeight>
struct FrameTrackerStorage {
  static constexpr std::size_t kPixels =
      static_cast<std::size_t>(MaxWidth) * static_cast<std::size_t>(MaxHeight);

  std::array<std::array<std::int16_t, pyramid_values(MaxWidth, MaxHeight)>, 2> pyramids;
  std::array<std::uint16_t, static_cast<std::size_t>(padded_stride(MaxWidth))> row;
  std::array<float, kCornerScratchRows* static_cast<std::size_t>(MaxWidth)> corner_rows;
  std::array<float, kPixels> response;
  std::array<std::uint8_t, kPixels> mask;
  std::array<Corner, kMaxCornerCells> corner_cells;
  std::array<std::int16_t, ReferencePatches::kValues> reference_patches;

  [[nodiscard]] FrameTrackerBuffers view() noexcept {
    return {MaxWidth, MaxHeight,    {pyramids[0], pyramids[1]}, row, corner_rows, response,
            mask,     corner_cells, reference_patches};
  }
};

/// What a tracker follows, and what its points are called.
struct TrackerRole {
  std::uint8_t camera_index = 0;  ///< written to each point
  FeatureKind kind = FeatureKind::kImagePoint;
};

/// Ids of event points begin here, so that they differ from those of image points.
inline constexpr FeatureId kFirstEventPointId = 0x8000'0001U;

/// A least distance given for pictures 240 px wide, for others: in proportion, up to three times.
[[nodiscard]] double scaled_distance_px(double distance_px, int width_px) noexcept;

/// Follows corners through the frames of one camera: Shi-Tomasi corners, spread over the image;
/// pyramidal Lucas-Kanade that starts where the gyro's rotation takes each point; a last alignment
/// with the track's first view against drift; a forward-backward check; and the two-point motion
/// check. With kind kEventPoint the frames are time surfaces: corners are offered by the caller,
/// and a patch that is lost is looked for once more with polarities exchanged, as it looks after
/// the motion has reversed. No allocation, no clock, no thread: the same calls give the same bits.
class FrameTracker {
 public:
  /// @param config  valid: check(config).key == nullptr
  /// @param camera  its width and height are the size of every frame; they fit the buffers
  /// @param buffers  those for finding corners may be empty for kEventPoint
  FrameTracker(const FrontendConfig& config, const Camera& camera,
               const FrameTrackerBuffers& buffers, const TrackerRole& role = {}) noexcept;

  /// Follows all tracks into `frame` and looks for new corners. `out` is written whole: tracks
  /// first, oldest first, then new corners (track_length 1, bearing_rate 0).
  ///
  /// @param t_imu  mid-exposure on the estimator clock
  /// @param R_prev_cur_cam  takes coordinates of this frame's camera to those of the previous
  ///        tracked frame's; nullopt: unknown, then points are expected where they were and the
  ///        motion check is skipped (all inliers)
  /// @returns false when the frame is not of the camera's size: it is skipped, `out` has its
  ///        stamps and no points, the tracks stay as they were.
  bool track(const FrameView& frame, Timestamp t_imu,
             const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
             FrameMeasurement& out) noexcept;

  /// The same with new corners from `offered`, best first, instead of Shi-Tomasi's: those that keep
  /// the minimum distance from the tracks and from each other, as far as there is room.
  bool track(const FrameView& frame, Timestamp t_imu,
             const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
             std::span<const Corner> offered, FrameMeasurement& out) noexcept;

  /// Says that the times given so far were early by `shift`: the last frame is moved with the
  /// clock, and what was compared by the gyro at the wrong times is forgotten. Tracks go on.
  void shift_clock(Duration shift) noexcept;

  /// Ends all tracks. Ids go on, so none is used twice.
  void reset() noexcept;

  [[nodiscard]] const Camera& camera() const noexcept { return camera_; }

 private:
  [[nodiscard]] bool follow_into(const FrameView& frame, Timestamp t_imu,
                                 const std::optional<Eigen::Quaterniond>& R_prev_cur_cam,
                                 FrameMeasurement& out) noexcept;
  void follow_all(const FramePair& frames) noexcept;
  void drop_crowded() noexcept;
  void drop_struck_out() noexcept;
  void find_corners() noexcept;
  void choose_from(std::span<const Corner> offered) noexcept;
  void begin_tracks() noexcept;
  void write(FrameMeasurement& out) const noexcept;
  /// Keeps the tracks for which `keep(i)` holds, in order; the others end and count as lost.
  template <typename Keep>
  void keep_if(const Keep& keep) noexcept;
  [[nodiscard]] std::span<PointTrack> tracks() noexcept { return {tracks_.data(), num_tracks_}; }

  FrontendConfig config_;
  Camera camera_;
  TrackerRole role_;
  FrameTrackerBuffers buffers_;
  double min_distance_px_;
  std::array<Pyramid, 2> pyramids_;
  std::size_t current_ = 0;  ///< index of the newest pyramid
  PointFollower follower_;
  TrackMotion motion_;

  std::array<PointTrack, limits::kMaxPoints> tracks_{};
  std::size_t num_tracks_ = 0;
  FixedVector<Corner, limits::kMaxPoints> corners_;
  FeatureId next_id_;
  std::uint32_t lost_ = 0;
  std::optional<Timestamp> t_previous_;
};

}  // namespace pled
