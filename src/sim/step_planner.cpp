#include "src/sim/step_planner.hpp"

#include <algorithm>
#include <vector>

namespace pled::sim {
namespace {

constexpr int kGridPx = 8;
constexpr double kProbeS = 1e-3;
constexpr double kShortestStepS = 1e-4;

}  // namespace

double plan_step_s(const World& world, const Renderer& renderer, const Trajectory& trajectory,
                   const SimulationOptions& options, const View& view, double t_s) {
  const Pose& T_body_cam = options.camera.T_body_cam;
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
  const double motion_px = fastest * std::max(options.camera.fx_px, options.camera.fy_px);
  const double step_s = options.events.max_motion_px * kProbeS / std::max(motion_px, 1e-9);
  return std::clamp(step_s, kShortestStepS, options.events.max_step_s);
}

}  // namespace pled::sim
