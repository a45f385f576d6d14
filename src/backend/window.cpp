#include "pled_vins/backend/window.hpp"

namespace pled {

void SlidingWindow::clear() noexcept {
  order_.clear();
  landmarks.clear();
  lines.clear();
  prior.clear();
}

WindowState* SlidingWindow::push_state() noexcept {
  if (full()) return nullptr;
  std::array<bool, limits::kWindowStates> taken{};
  for (const std::uint8_t slot : order_) taken[slot] = true;
  std::uint8_t slot = 0;
  while (taken[slot]) ++slot;
  if (!order_.push_back(slot)) return nullptr;
  WindowState& s = slots_[slot];
  s.x = s.first = NavState{};
  s.has_first = s.keyframe = s.still = s.has_imu = false;
  s.still_as = -1;
  s.still_share = 1.0;
  s.imu.clear();
  s.prior.reset();
  return &s;
}

void SlidingWindow::drop_observations(Landmark& landmark, std::size_t count,
                                      const RigCalibration& rig) noexcept {
  auto& seen = landmark.observations;
  if (count == 0) return;
  if (count < seen.size() && landmark.has_depth) {
    const Observation& from = seen[0];
    const Observation& to = seen[count];
    const Pose T_wc_from = state(from.state).x.T_world_body() * T_body_cam(from.camera, rig);
    const Pose T_wc_to = state(to.state).x.T_world_body() * T_body_cam(to.camera, rig);
    const Pose T = T_wc_to.inverse() * T_wc_from;
    // The point scaled by its inverse depth: finite at infinity too.
    const Eigen::Vector3d c = T.q * landmark.ray() + landmark.inverse_depth_pm() * T.p;
    landmark.bearing_depth = {c.x() / c.z(), c.y() / c.z(), landmark.inverse_depth_pm() / c.z()};
    if (!(c.z() > 0.05)) landmark.has_depth = false;
  }
  for (std::size_t k = count; k < seen.size(); ++k) seen[k - count] = seen[k];
  for (std::size_t k = 0; k < count && !seen.empty(); ++k) seen.pop_back();
}

void SlidingWindow::erase_state(std::size_t i, const RigCalibration& rig) noexcept {
  for (Landmark& landmark : landmarks) {
    auto& seen = landmark.observations;
    for (std::size_t k = 0; k < seen.size(); ++k) {
      if (seen[k].state != i) continue;
      if (k == 0) {
        drop_observations(landmark, 1, rig);
      } else {
        seen.erase(k);
      }
      break;
    }
    for (Observation& o : seen)
      if (o.state > i) --o.state;
  }
  for (LineLandmark& line : lines) {
    auto& seen = line.observations;
    for (std::size_t k = seen.size(); k-- > 0;) {
      if (seen[k].state == i) {
        seen.erase(k);
      } else if (seen[k].state > i) {
        --seen[k].state;
      }
    }
  }
  order_.erase(i);
  for (std::size_t k = 0; k < size(); ++k) {
    int& as = state(k).still_as;
    if (as == static_cast<int>(i)) as = -1;
    if (as > static_cast<int>(i)) --as;
  }
  for (std::size_t k = i; k + 1 < limits::kWindowStates; ++k) {
    prior.pose_column[k] = prior.pose_column[k + 1];
    prior.motion_column[k] = prior.motion_column[k + 1];
  }
  prior.pose_column.back() = prior.motion_column.back() = -1;
}

Landmark* SlidingWindow::find(FeatureId id) noexcept {
  for (Landmark& landmark : landmarks)
    if (landmark.id == id) return &landmark;
  return nullptr;
}

LineLandmark* SlidingWindow::find_line(FeatureId id) noexcept {
  for (LineLandmark& line : lines)
    if (line.id == id) return &line;
  return nullptr;
}

}  // namespace pled
