#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pled_vins/reliability/motion_cue.hpp"

namespace pled::support {

inline constexpr double kFocal_px = 200.0;

/// A camera of kFocal_px without lens errors.
[[nodiscard]] inline CameraCalibration pinhole_200() {
  CameraCalibration c;
  c.width_px = 240;
  c.height_px = 180;
  c.fx_px = c.fy_px = kFocal_px;
  c.cx_px = 120.0;
  c.cy_px = 90.0;
  return c;
}

[[nodiscard]] inline RigCalibration one_camera_rig() {
  RigCalibration rig;
  rig.num_cameras = 1;
  rig.cameras[0] = pinhole_200();
  return rig;
}

inline constexpr double kStep_m = 0.05;  ///< what the camera moves along x from frame to frame

[[nodiscard]] inline Pose sideways(int k) {
  return {Eigen::Quaterniond::Identity(), {kStep_m * k, 0, 0}};
}

/// One point as it is seen now.
struct Sighting {
  FeatureId id = 0;
  Eigen::Vector2d bearing;
  std::uint8_t camera = 0;
};

/// A motion cue that is told the true poses, one frame each 50 ms.
class WatchedPoints {
 public:
  explicit WatchedPoints(const RigCalibration& rig, const MotionCueConfig& config = {})
      : rig_(rig), cue_(config, rig) {}

  [[nodiscard]] MotionCue& cue() { return cue_; }
  [[nodiscard]] Timestamp next_time() const { return {(frames_ + 1) * 50'000}; }

  /// Where a camera has a point of the world.
  [[nodiscard]] Eigen::Vector2d bearing(const Pose& T_world_body, const Eigen::Vector3d& p_world,
                                        std::uint8_t camera = 0) const {
    const Pose T_world_cam = T_world_body * rig_.cameras[camera].T_body_cam;
    return (T_world_cam.inverse() * p_world).hnormalized();
  }

  /// Judges a frame. Gives the cue the newest `poses` of those it may use.
  std::span<const MotionEvidence> show(const Pose& T_world_body,
                                       std::span<const Sighting> sightings,
                                       std::size_t poses = limits::kCueFrames + 1) {
    FrameMeasurement frame;
    frame.t = next_time();
    for (const Sighting& s : sightings) {
      PointMeasurement p;
      p.id = s.id;
      p.camera = s.camera;
      p.bearing_xy = {s.bearing.x(), s.bearing.y()};
      (void)frame.points.push_back(p);
    }
    path_.insert(path_.begin(), T_world_body);
    const std::size_t known = std::min(poses, cue_.times(frame.t).size());
    out_.fill({-1.0, -1.0, -1.0, -1.0, true, 99});  // judge() must write all
    cue_.judge(frame, std::span(path_).first(known), true, out_);
    ++frames_;
    return std::span(out_).first(sightings.size());
  }

 private:
  RigCalibration rig_;
  MotionCue cue_;
  std::vector<Pose> path_;  ///< newest first
  std::int64_t frames_ = 0;
  std::array<MotionEvidence, limits::kMaxPoints> out_{};
};

}  // namespace pled::support
