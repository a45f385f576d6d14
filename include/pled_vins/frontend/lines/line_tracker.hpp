#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Geometry>

#include "pled_vins/core/limits.hpp"
#include "pled_vins/core/messages.hpp"
#include "pled_vins/frontend/lines/config.hpp"
#include "pled_vins/frontend/lines/line_detector.hpp"
#include "pled_vins/frontend/lines/line_match.hpp"
#include "pled_vins/frontend/lines/line_measurement.hpp"
#include "pled_vins/geometry/camera.hpp"

namespace pled {

/// What a line tracker looks at, and what its lines are called.
struct LineRole {
  std::uint8_t camera_index = 0;  ///< written to each line
  LinePicture picture = LinePicture::kGrey;
  FeatureId first_id = kFirstImageLineId;
};

/// Follows straight edges through the pictures of one camera: those of each picture are detected
/// anew and matched with where the gyro's rotation, and the line's own motion across so far, put
/// those known. A line that is missing for up to two pictures is carried on and may come back, as
/// long as there is room beside those seen.
/// No clock, no thread; no allocation but that of find_pieces(): the same calls give the same bits.
class LineTracker {
 public:
  /// @param config  valid: check(config).key == nullptr
  /// @param camera  its size is that of every picture; it fits the buffers
  LineTracker(const LineConfig& config, const Camera& camera, const LineBuffers& buffers,
              const LineRole& role = {}) noexcept;

  /// Detects the lines of `frame` and matches them. `out` is written whole: lines followed, oldest
  /// first, then new ones (track_length 1), longest first.
  ///
  /// A line more than 2 px or 2 degrees off where rotation and its motion so far put it has jumped
  /// to another edge: its track ends, and what is seen there is new. So each line given out is an
  /// inlier. Rates are those since a line was last seen, the camera's turning included.
  /// @param t_imu  of the picture, estimator clock
  /// @param R_prev_cur_cam  takes coordinates of this picture's camera to those of the previous
  ///        tracked one's; nullopt: unknown, then lines are expected where they were going
  /// @returns false when the picture is not of the camera's size or memory ran out: it is skipped,
  ///        `out` has its stamps and no lines, the tracks stay as they were.
  bool track(const FrameView& frame, Timestamp t_imu,
             const std::optional<Eigen::Quaterniond>& R_prev_cur_cam, LineFrame& out) noexcept;

  /// Says that the times given so far were early by `shift`. Tracks go on; their motion, which was
  /// told from the gyro's by wrong times, is forgotten.
  void shift_clock(Duration shift) noexcept;

  /// Ends all tracks. Ids go on, so none is used twice.
  void reset() noexcept;

 private:
  using Ends = std::array<std::array<double, 2>, 2>;

  struct Track {
    FeatureId id = 0;
    std::uint32_t length = 1;
    int missed = 0;            ///< pictures since it was seen
    bool has_motion = false;   ///< across_pxps is known
    double across_pxps = 0.0;  ///< motion along its normal, rotation taken out
    DetectedLine line;         ///< as last seen, or where it should be by now
    Ends bearing_xy{};         ///< as last seen
    Ends bearing_rate_xyps{};
    Timestamp t_seen;
  };

  void expect_all(const Eigen::Matrix3d& R_cur_prev, double dt_s) noexcept;
  [[nodiscard]] bool turn(const Eigen::Matrix3d& R_cur_prev, Segment& segment) const noexcept;
  [[nodiscard]] Ends bearings_of(const Segment& segment) const noexcept;
  void take_matches(Timestamp t, double dt_s) noexcept;
  void end_missing() noexcept;
  void end(std::size_t i) noexcept;
  void begin_tracks(Timestamp t) noexcept;
  void write(LineFrame& out) const noexcept;

  LineConfig config_;
  LineRole role_;
  LineDetector detector_;
  double search_px_;

  std::array<Track, limits::kMaxLines> tracks_{};
  std::size_t num_tracks_ = 0;
  std::array<ExpectedLine, limits::kMaxLines> expected_{};
  std::array<double, limits::kMaxLines> moved_px_{};  ///< part of the expectation that is motion
  DetectedLines seen_;
  std::array<bool, limits::kMaxLines> is_known_{};  ///< lines seen that go on with a track
  FeatureId next_id_;
  std::uint32_t lost_ = 0;
  std::optional<Timestamp> t_previous_;
};

}  // namespace pled
