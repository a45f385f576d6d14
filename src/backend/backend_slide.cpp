#include <algorithm>

#include "pled_vins/backend/backend.hpp"

namespace pled {

bool Backend::is_keyframe(const FrameMeasurement& frame) const noexcept {
  const std::size_t newest = window_.size() - 1;
  std::size_t reference = newest;
  while (reference > 0 && !window_.state(reference - 1).keyframe) --reference;
  if (reference == 0) return true;
  --reference;
  const WindowState& from = window_.state(reference);
  const WindowState& to = window_.state(newest);
  std::array<double, kMaxLandmarks> parallax;
  std::size_t common = 0;
  for (const Landmark& l : window_.landmarks) {
    if (l.rejected || l.observations.back().state != newest) continue;
    for (const Observation& o : l.observations) {
      if (o.state != reference) continue;
      const Observation& now = l.observations.back();
      const Eigen::Quaterniond q_cj_ci =
          (to.x.q_wb * window_.T_body_cam(now.camera, rig_).q).conjugate() *
          (from.x.q_wb * window_.T_body_cam(o.camera, rig_).q);
      const Eigen::Vector3d turned = q_cj_ci * Eigen::Vector3d(o.xy[0], o.xy[1], 1.0);
      if (!(turned.z() > 0.1)) break;
      const Eigen::Vector2d d =
          Eigen::Vector2d(now.xy[0], now.xy[1]) - turned.head<2>() / turned.z();
      parallax[common++] = 200.0 * d.norm();  // pixels at f = 200 px, as the setting says
      break;
    }
  }
  const bool renewed = 2 * common < frame.points.size() || common < 20;
  // A long standstill outlives its tracks: those that came since must be held from somewhere.
  if (to.still) return to.still_as < 0 || renewed;
  if (renewed) return true;
  const auto middle = parallax.begin() + static_cast<std::ptrdiff_t>(common / 2);
  std::nth_element(parallax.begin(), middle,
                   parallax.begin() + static_cast<std::ptrdiff_t>(common));
  const bool late = to.x.t - from.x.t >= Duration::from_ms(500);
  return *middle >= config_.keyframe_parallax_px ||
         (late && *middle >= 0.2 * config_.keyframe_parallax_px);
}

/// Makes room for the next state: the second newest goes when it is no keyframe, else, of a full
/// window, the oldest.
void Backend::slide() noexcept {
  if (window_.size() < 3) return;
  const WindowState& second = window_.state(window_.size() - 2);
  if (!second.keyframe && (window_.full() || second.still)) {
    drop_second_newest();
  } else if (window_.full()) {
    if (!marginaliser_.marginalise(window_, rig_, settings_, 0)) ++faults_.priors_lost;
  }
}

void Backend::drop_second_newest() noexcept {
  const std::size_t k = window_.size() - 2;
  WindowState& gone = window_.state(k);
  WindowState& next = window_.state(k + 1);
  const bool touched = (window_.prior.valid && (window_.prior.pose_column[k] >= 0 ||
                                                window_.prior.motion_column[k] >= 0)) ||
                       gone.prior || gone.still;
  const bool fits = gone.has_imu && next.has_imu &&
                    gone.imu.size() + next.imu.size() <= limits::kMaxImuPerInterval;
  if (touched || !fits) {
    if (!marginaliser_.marginalise(window_, rig_, settings_, k)) ++faults_.priors_lost;
    return;
  }
  // One interval out of two; the sample at the joint is the same in both.
  for (std::size_t i = 1; i < next.imu.size(); ++i) (void)gone.imu.push_back(next.imu[i]);
  next.imu = gone.imu;
  const NavState& from = window_.state(k - 1).x;
  next.has_imu = next.preintegration.integrate(next.imu.span(), from.bg, from.ba, noise_);
  window_.erase_state(k, rig_);
}

}  // namespace pled
