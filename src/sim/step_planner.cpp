#include "src/sim/step_planner.hpp"

#include <algorithm>
#include <vector>

namespace pled::sim {
namespace {

constexpr int kGridPx = 8;
constexpr double kProbeS = 1e-3;
constexpr double kShortestStepS = 1e-4;

/// Flicker and flashes must be followed too.
double longest_step_s(const SimulationOptions& options) {
  double longest_s = options.events.max_step_s;
  constexpr double kRendersPerFlicker = 16.0;
  if (options.faults.flicker_hz > 0.0)
    longest_s = std::min(longest_s, 1.0 / (kRendersPerFlicker * options.faults.flicker_hz));
  if (options.faults.flash_at_s >= 0.0)
    longest_s = std::min(longest_s, 0.25 * options.faults.flash_length_s);
  return longest_s;
}

}  // namespace

double plan_step_s(const World& world, const Renderer& renderer, const Trajectory& trajectory,
                   const SimulationOptions& options, const View& view, double t_s) {
  const CameraCalibration& camera = options.camera_of_events();
  const Pose& T_body_cam = camera.T_body_cam;
  const Pose T_world_cam = trajectory.at(t_s).T_world_body * T_body_cam;
  const Pose T_cam_world_next = (trajectory.at(t_s + kProbeS).T_world_body * T_body_cam).inverse();
  // From this camera to the next one, riding on each box.
  std::vector<Pose> carried;
  for (const Box& box : world.boxes)
    carried.push_back(T_cam_world_next * box.T_world_box(t_s + kProbeS) *
                      box.T_world_box(t_s).inverse() * T_world_cam);

  double fastest = 0.0;  // change of ray per probe time, focal lengths
  for (int y = kGridPx / 2; y < renderer.height(); y += kGridPx) {
    for (int x = kGridPx / 2; x < renderer.width(); x += kGridPx) {
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(renderer.width()) +
                     static_cast<std::size_t>(x);
      const Eigen::Vector2d ray = renderer.ray(i).cast<double>();
      const Eigen::Vector3d p_cam =
          static_cast<double>(view.depth_m[i]) * Eigen::Vector3d{ray.x(), ray.y(), 1.0};
      const Eigen::Vector3d next = carried[view.surface[i] / 6U] * p_cam;
      if (next.z() > 0.0) fastest = std::max(fastest, (next.head<2>() / next.z() - ray).norm());
    }
  }
  // The lens only shrinks what the focal length gives (barrel), so this is the upper bound.
  const double motion_px = fastest * std::max(camera.fx_px, camera.fy_px);
  const double step_s = options.events.max_motion_px * kProbeS / std::max(motion_px, 1e-9);
  return std::clamp(step_s, kShortestStepS, longest_step_s(options));
}

}  // namespace pled::sim
