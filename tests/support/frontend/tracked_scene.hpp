#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "pled_vins/frontend/frame_tracker.hpp"
#include "pled_vins/geometry/so3.hpp"
#include "support/frontend/plane_scene.hpp"

namespace pled::support {

using Storage240 = FrameTrackerStorage<240, 180>;

/// A camera pose at (x, y, z) m, turned by the rotation vector `phi` (rad).
[[nodiscard]] inline Pose pose_at(double x, double y, double z,
                                  const Eigen::Vector3d& phi = Eigen::Vector3d::Zero()) {
  return {so3::exp(phi), {x, y, z}};
}

/// Brightness of a frame: grey = offset + gain x texture + noise.
struct Exposure {
  double gain = 180.0;
  double offset = 30.0;
  double noise_grey = 0.0;
};

/// A tracker that watches a textured plane, and the truth about each of its points.
class TrackedScene {
 public:
  explicit TrackedScene(bool distorted, const FrontendConfig& config = {}, std::uint64_t seed = 1)
      : camera_(davis240_camera(distorted)),
        scene_(camera_, Texture(seed, 0.04, 0.5)),
        storage_(std::make_unique<Storage240>()),
        tracker_(config, camera_, storage_->view()) {}

  [[nodiscard]] FrameTracker& tracker() { return tracker_; }
  [[nodiscard]] const FrameMeasurement& measured() const { return measured_; }

  [[nodiscard]] GreyImage render(const Pose& T_world_cam, const Exposure& e = {}) {
    return scene_.render(T_world_cam, e.gain, e.offset, e.noise_grey, random_);
  }

  /// Shows the tracker an image taken at `T_world_cam`, with the true rotation unless told not to.
  void show(const Pose& T_world_cam, const GreyImage& image, bool tell_rotation = true) {
    std::optional<Eigen::Quaterniond> rotation;
    if (!poses_.empty() && tell_rotation) rotation = poses_.back().q.conjugate() * T_world_cam.q;
    FrameView frame;
    frame.t = Timestamp{static_cast<std::int64_t>(poses_.size()) * 50'000};
    frame.stamp_ns = frame.t.us * 1000;
    frame.image = image.view();
    tracker_.track(frame, frame.t, rotation, measured_);
    poses_.push_back(T_world_cam);
    for (const PointMeasurement& p : measured_.points)
      if (p.track_length == 1)
        births_[p.id] = {Eigen::Vector2d(p.raw_px[0], p.raw_px[1]), poses_.size() - 1};
  }
  void show(const Pose& T_world_cam, const Exposure& e = {}) {
    show(T_world_cam, render(T_world_cam, e));
  }

  /// Where the point that was first seen at the birth of this track is in the newest frame.
  [[nodiscard]] std::optional<Eigen::Vector2d> truth(const PointMeasurement& p) const {
    const auto birth = births_.find(p.id);
    if (birth == births_.end()) return std::nullopt;
    return scene_.transfer(birth->second.px, poses_[birth->second.frame], poses_.back());
  }

  /// Distances to the truth of all tracks of at least `min_length` frames, smallest first.
  [[nodiscard]] std::vector<double> errors_px(std::uint32_t min_length = 2) const {
    std::vector<double> errors;
    for (const PointMeasurement& p : measured_.points) {
      if (p.track_length < min_length) continue;
      const std::optional<Eigen::Vector2d> want = truth(p);
      errors.push_back(want ? (Eigen::Vector2d(p.raw_px[0], p.raw_px[1]) - *want).norm() : 1e9);
    }
    std::sort(errors.begin(), errors.end());
    return errors;
  }

 private:
  struct Birth {
    Eigen::Vector2d px;
    std::size_t frame = 0;
  };
  Camera camera_;
  PlaneScene scene_;
  std::unique_ptr<Storage240> storage_;
  FrameTracker tracker_;
  FrameMeasurement measured_;
  std::vector<Pose> poses_;
  std::map<FeatureId, Birth> births_;
  std::mt19937_64 random_{11};
};

/// The value below which `share` of the sorted values lie.
[[nodiscard]] inline double quantile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 1e9;
  const auto i = static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1));
  return sorted[i];
}

}  // namespace pled::support
