#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "pled_vins/reliability/line_motion_cue.hpp"
#include "support/reliability/watched_points.hpp"

namespace pled::support {

using Ends = std::array<Eigen::Vector2d, 2>;      ///< on the plane z = 1
using Segment3 = std::array<Eigen::Vector3d, 2>;  ///< in the world, m

struct LineSighting {
  FeatureId id = kFirstImageLineId;
  Ends ends;
};

/// Where a camera of one_camera_rig() has a segment of the world.
[[nodiscard]] inline Ends ends_of(const Pose& T_world_cam, const Segment3& segment) {
  const Pose T = T_world_cam.inverse();
  return {(T * segment[0]).hnormalized(), (T * segment[1]).hnormalized()};
}

[[nodiscard]] inline Segment3 moved(const Segment3& segment, const Eigen::Vector3d& by) {
  return {segment[0] + by, segment[1] + by};
}

/// The cues of points and of lines, told the same poses.
class WatchedLines {
 public:
  explicit WatchedLines(const MotionCueConfig& config = {})
      : points_(config, one_camera_rig()), lines_(config, one_camera_rig()) {}

  [[nodiscard]] LineMotionCue& cue() { return lines_; }

  /// Judges a frame. Gives the cues the newest `poses` of those they may use.
  std::span<const LineMotionEvidence> show(const Pose& T_world_body,
                                           std::span<const LineSighting> lines,
                                           std::span<const Sighting> points = {},
                                           std::size_t poses = limits::kCueFrames + 1) {
    FrameMeasurement frame;
    frame.t = Timestamp{++frames_ * 50'000};
    for (const LineSighting& s : lines) {
      LineMeasurement line;
      line.id = s.id;
      for (std::size_t k = 0; k < 2; ++k) line.bearing_xy[k] = {s.ends[k].x(), s.ends[k].y()};
      (void)frame.lines.push_back(line);
    }
    for (const Sighting& s : points) {
      PointMeasurement p;
      p.id = s.id;
      p.bearing_xy = {s.bearing.x(), s.bearing.y()};
      (void)frame.points.push_back(p);
    }
    path_.insert(path_.begin(), T_world_body);
    const std::size_t known = std::min(poses, points_.times(frame.t).size());
    const std::span<const Pose> path = std::span(path_).first(known);
    points_.judge(frame, path, true, point_out_);
    out_.fill({-1.0, -1.0, {-1.0, -1.0}, -1.0, -1.0, true, 99});  // judge() must write all
    lines_.judge(frame, path, true, point_out_, out_);
    return std::span(out_).first(lines.size());
  }

 private:
  MotionCue points_;
  LineMotionCue lines_;
  std::vector<Pose> path_;  ///< newest first
  std::int64_t frames_ = 0;
  std::array<MotionEvidence, limits::kMaxPoints> point_out_{};
  std::array<LineMotionEvidence, limits::kMaxLines> out_{};
};

}  // namespace pled::support
