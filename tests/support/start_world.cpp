#include "tests/support/start_world.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

namespace pled::support {

BackendConfig start_config() {
  BackendConfig config;
  config.point_sigma_px = std::max(config.point_sigma_px, config.start_sigma_px);
  return config;
}

void fill_history(const PointWorld& world, Timestamp until, ImuHistory& imu) {
  for (const ImuSample& sample : world.imu())
    if (sample.t <= until + Duration::from_ms(20)) imu.add(sample);
}

StartFrames start_frames(const PointWorld& world, std::size_t first, double span_s) {
  StartFrames frames;
  const auto all = world.frames();
  std::size_t last = first;
  while (last + 1 < all.size() && (all[last + 1].t - all[first].t).seconds() <= span_s + 1e-4)
    ++last;
  const std::size_t num = std::min(last - first + 1, StartFrames::capacity());
  for (std::size_t k = 0; k < num; ++k) {
    const std::size_t at = first + (num > 1 ? k * (last - first) / (num - 1) : 0);
    if (!frames.push_back(all[at])) break;
  }
  return frames;
}

void add_cluster(const PointWorld& world, double share, double speed_mps, std::uint64_t seed,
                 StartFrames& frames) {
  std::mt19937_64 random(seed);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  const double focal = world.rig().cameras[0].fx_px;
  const double sigma = world.options().pixel_sigma / focal;
  const Pose T_bc = world.rig().cameras[0].T_body_cam;
  const auto noise = [&] {
    return sigma * (unit() + unit() + unit() + unit() - 2) * std::sqrt(3.0);
  };
  // A box to the left or right of the image: the points that are there when first seen join.
  const double from = unit() < 0.5 ? -0.6 : 0.6 - 1.2 * share;
  const double depth_m = 3 + 3 * unit();
  const Pose T_wc0 = world.truth(frames.front().t).T_world_body() * T_bc;
  const double angle = 6.283185307 * unit();
  const Eigen::Vector3d v_w =
      T_wc0.q *
      (speed_mps * Eigen::Vector3d(std::cos(angle), 0.2 * std::sin(angle), std::sin(angle)));
  std::map<FeatureId, Eigen::Vector3d> members;  // position at frame 0
  std::map<FeatureId, bool> seen;
  for (FrameMeasurement& frame : frames) {
    const double t_s = (frame.t - frames.front().t).seconds();
    const Pose T_wc = world.truth(frame.t).T_world_body() * T_bc;
    const Pose T_cw = T_wc.inverse();
    FixedVector<PointMeasurement, limits::kMaxPoints> kept;
    for (PointMeasurement point : frame.points) {
      if (!seen[point.id]) {
        seen[point.id] = true;
        const double x = point.bearing_xy[0];
        const double d = depth_m + 0.5 * unit();
        if (x > from && x < from + 1.2 * share)
          members[point.id] = T_wc * Eigen::Vector3d(x * d, point.bearing_xy[1] * d, d) - v_w * t_s;
      }
      if (const auto at = members.find(point.id); at != members.end()) {
        const Eigen::Vector3d p = T_cw * (at->second + v_w * t_s);
        if (!(p.z() > 0.2) || std::abs(p.x()) > 0.6 * p.z() || std::abs(p.y()) > 0.45 * p.z())
          continue;
        point.bearing_xy = {p.x() / p.z() + noise(), p.y() / p.z() + noise()};
      }
      if (!kept.push_back(point)) break;
    }
    frame.points = kept;
  }
}

StartError start_error(const PointWorld& world, const StartGuess& guess) {
  StartError e;
  const NavState first = world.truth(guess.states.front().t);
  const NavState last = world.truth(guess.states.back().t);
  const auto n = static_cast<double>(guess.states.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d true_mean = Eigen::Vector3d::Zero();
  for (const NavState& s : guess.states) {
    mean += s.p_wb / n;
    true_mean += world.truth(s.t).p_wb / n;
  }
  double size = 0;
  double true_size = 0;
  for (const NavState& s : guess.states) {
    size += (s.p_wb - mean).squaredNorm();
    true_size += (world.truth(s.t).p_wb - true_mean).squaredNorm();
  }
  e.scale = std::sqrt(size / true_size) - 1;
  const NavState& a = guess.states.front();
  const NavState& b = guess.states.back();
  e.position_m =
      (a.q_wb.conjugate() * (b.p_wb - a.p_wb) - first.q_wb.conjugate() * (last.p_wb - first.p_wb))
          .norm();
  e.velocity_mps = (b.q_wb.conjugate() * b.v_wb - last.q_wb.conjugate() * last.v_wb).norm();
  const Eigen::Vector3d down = b.q_wb.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d true_down = last.q_wb.conjugate() * Eigen::Vector3d::UnitZ();
  e.gravity_rad = std::atan2(down.cross(true_down).norm(), down.dot(true_down));
  e.gyro_bias_radps = (b.bg - last.bg).norm();
  return e;
}

}  // namespace pled::support
