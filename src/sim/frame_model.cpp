#include "src/sim/frame_model.hpp"

#include <algorithm>
#include <cmath>

#include "src/sim/random.hpp"

namespace pled::sim {
namespace {

std::vector<std::uint8_t> label(const World& world, const View& view, double t_s) {
  std::vector<bool> moving;
  for (const Box& box : world.boxes) moving.push_back(box.speed_mps(t_s) > kMovingSpeedMps);
  std::vector<std::uint8_t> mask(view.surface.size());
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = moving[view.surface[i] / 6U] ? 255 : 0;
  return mask;
}

std::vector<std::uint16_t> millimetres(const std::vector<float>& depth_m) {
  std::vector<std::uint16_t> out(depth_m.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const float mm = 1000.0F * depth_m[i];
    out[i] = mm < 65535.0F ? static_cast<std::uint16_t>(std::lround(mm)) : std::uint16_t{0};
  }
  return out;
}

}  // namespace

Frame expose_frame(const World& world, const Renderer& renderer, const Trajectory& trajectory,
                   const SimulationOptions& options, double t_s, std::uint64_t index) {
  const Pose& T_body_cam = options.camera.T_body_cam;
  const int samples = options.frames.blur_samples;
  Frame frame;
  View view;
  std::vector<float> sum;
  for (int k = 0; k < samples; ++k) {
    // Middles of equal parts of the exposure; the middle one is at mid-exposure.
    const int from_middle = k - samples / 2;
    const double share = static_cast<double>(from_middle) / static_cast<double>(samples);
    const double when_s = t_s + share * options.frames.exposure_s;
    renderer.render(trajectory.at(when_s).T_world_body * T_body_cam, when_s, view);
    sum.resize(view.radiance.size(), 0.0F);
    const auto light = static_cast<float>(brightness(options.faults, when_s));
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += light * view.radiance[i];
    if (k != samples / 2) continue;
    frame.mask = label(world, view, t_s);
    if (options.with_depth) frame.depth_mm = millimetres(view.depth_m);
  }
  const auto grey_per_unit = static_cast<float>(255.0 * options.frames.gain);
  Random random = stream(options.seed, Stream::kFrames, index);
  frame.grey.resize(sum.size());
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const float mean = grey_per_unit * sum[i] / static_cast<float>(samples);
    const double grey = static_cast<double>(mean) + options.frames.noise_grey * random.gaussian();
    frame.grey[i] = static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L));
  }
  return frame;
}

}  // namespace pled::sim
