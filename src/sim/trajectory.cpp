#include "pled_vins/sim/trajectory.hpp"

#include <cmath>
#include <numbers>

#include "src/sim/random.hpp"
#include "src/sim/spline_trajectory.hpp"

namespace pled::sim {
namespace {

constexpr double kRampS = 1.5;  // from rest to full pace

/// Body axes (x right, y down, z forward, as a camera) to vehicle axes (x forward, y left, z up).
Eigen::Matrix3d vehicle_from_body() noexcept {
  Eigen::Matrix3d m;
  m << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return m;
}

/// Angular rate in vehicle axes from Euler angles (z-y-x order) and their rates.
Eigen::Vector3d euler_rate(double roll, double pitch, const Eigen::Vector3d& rpy_rate) noexcept {
  const double sr = std::sin(roll), cr = std::cos(roll);
  const double sp = std::sin(pitch), cp = std::cos(pitch);
  return {rpy_rate.x() - sp * rpy_rate.z(), cr * rpy_rate.y() + sr * cp * rpy_rate.z(),
          -sr * rpy_rate.y() + cr * cp * rpy_rate.z()};
}

/// Amplitude (m, rad) and rate (rad/s) of three sines a coordinate: a wide path, a slower sway on
/// it, and the shake of a hand or of a motor.
struct Profile {
  double position[3][6];  ///< x y z
  double angles[3][6];    ///< roll pitch yaw
  double height_m;
};

constexpr Profile kRoomDrone{{{1.05, 0.82, 0.24, 2.1, 0.008, 11.0},
                              {1.25, 0.68, 0.22, 1.8, 0.009, 9.5},
                              {0.28, 1.05, 0.07, 2.6, 0.007, 12.0}},
                             {{0.13, 0.75, 0.05, 1.9, 0.010, 10.5},
                              {0.10, 0.95, 0.04, 2.2, 0.010, 9.0},
                              {0.55, 0.55, 0.10, 1.4, 0.010, 8.0}},
                             1.45};
constexpr Profile kHand{{{0.35, 1.3, 0.10, 3.1, 0.010, 11.0},
                         {0.45, 1.1, 0.10, 2.7, 0.010, 9.5},
                         {0.15, 1.6, 0.05, 3.4, 0.010, 12.0}},
                        {{0.20, 2.1, 0.12, 5.3, 0.020, 12.5},
                         {0.16, 2.4, 0.10, 6.1, 0.020, 11.0},
                         {0.40, 1.9, 0.33, 7.4, 0.030, 12.0}},
                        1.45};
constexpr Profile kLotDrone{{{2.4, 0.50, 0.5, 1.6, 0.010, 11.0},
                             {1.6, 0.85, 0.4, 1.9, 0.010, 9.5},
                             {0.45, 0.9, 0.1, 2.1, 0.008, 12.0}},
                            {{0.09, 0.7, 0.04, 1.9, 0.008, 10.5},
                             {0.07, 0.8, 0.04, 2.2, 0.008, 9.0},
                             {0.45, 0.33, 0.10, 1.1, 0.008, 8.0}},
                            1.7};
constexpr Profile kRoadCar{{{1.7, 1.0, 0.3, 1.4, 0.004, 14.0},
                            {0.7, 0.30, 0.1, 0.7, 0.003, 11.0},
                            {0.02, 1.9, 0.010, 5.2, 0.003, 13.0}},
                           {{0.012, 1.3, 0.006, 4.1, 0.003, 13.0},
                            {0.010, 1.1, 0.006, 4.7, 0.003, 12.0},
                            {0.006, 0.8, 0.003, 2.9, 0.001, 11.0}},
                           1.5};

const Profile& profile_of(const SimulationOptions& o) noexcept {
  if (o.motion == MotionKind::kCar) return kRoadCar;
  if (o.motion == MotionKind::kHandheld) return kHand;
  return o.world == WorldKind::kRoom ? kRoomDrone : kLotDrone;
}

}  // namespace

SineFlight::SineFlight(const SimulationOptions& o) noexcept
    : still_s_(o.still_s),
      starts_still_(o.start == StartKind::kStill),
      stands_(o.motion == MotionKind::kStill),
      heads_along_path_(o.motion == MotionKind::kCar) {
  const Profile& profile = profile_of(o);
  Random random = stream(o.seed, Stream::kFlight);
  const auto fill = [&](Channel& channel, const double(&row)[6], double size) {
    for (std::size_t k = 0; k < kTerms; ++k) {
      channel.terms[k] = {size * row[2 * k] * random.uniform(0.85, 1.15),
                          o.pace * row[2 * k + 1] * random.uniform(0.9, 1.1),
                          random.uniform(0.0, 2.0 * std::numbers::pi)};
    }
  };
  const double scale = o.world == WorldKind::kRoom ? o.scale : 1.0;
  for (std::size_t i = 0; i < 3; ++i) fill(position_[i], profile.position[i], scale);
  for (std::size_t i = 0; i < 3; ++i) fill(angles_[i], profile.angles[i], 1.0);
  position_[2].offset = profile.height_m * scale;
  if (heads_along_path_) position_[0].drift = o.speed_mps * o.pace;
}

Eigen::Vector3d SineFlight::Channel::at(double s) const noexcept {
  Eigen::Vector3d sum{offset + drift * s, drift, 0.0};
  for (const Sine& k : terms) {
    const double sine = std::sin(k.rate_radps * s + k.phase_rad);
    const double cosine = std::cos(k.rate_radps * s + k.phase_rad);
    sum += k.amplitude *
           Eigen::Vector3d{sine, k.rate_radps * cosine, -k.rate_radps * k.rate_radps * sine};
  }
  return sum;
}

SineFlight::Warp SineFlight::warp(double t_s) const noexcept {
  if (stands_) return {0.0, 0.0, 0.0};
  if (!starts_still_) return {t_s, 1.0, 0.0};
  const double x = (t_s - still_s_) / kRampS;
  if (!(x > 0.0)) return {0.0, 0.0, 0.0};
  if (x >= 1.0) return {(x - 0.5) * kRampS, 1.0, 0.0};
  // ds/dt = 10 x^3 - 15 x^4 + 6 x^5, flat to the second derivative at both ends.
  const double x3 = x * x * x;
  return {kRampS * x3 * x * (2.5 + x * (-3.0 + x)), x3 * (10.0 + x * (-15.0 + 6.0 * x)),
          30.0 * x * x * (1.0 - x) * (1.0 - x) / kRampS};
}

Kinematics SineFlight::at(double t_s) const noexcept {
  const Warp w = warp(t_s);
  Kinematics k;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const Eigen::Vector3d x = position_[i].at(w.s);
    k.T_world_body.p(axis) = x(0);
    k.v_wb_mps(axis) = x(1) * w.ds;  // chain rule through s(t)
    k.a_wb_mps2(axis) = x(2) * w.ds * w.ds + x(1) * w.dds;
  }
  const Eigen::Vector3d roll = angles_[0].at(w.s);
  const Eigen::Vector3d pitch = angles_[1].at(w.s);
  Eigen::Vector3d yaw = angles_[2].at(w.s);
  if (heads_along_path_) {
    const Eigen::Vector3d x = position_[0].at(w.s), y = position_[1].at(w.s);
    const double squared = x(1) * x(1) + y(1) * y(1);
    yaw += Eigen::Vector3d{std::atan2(y(1), x(1)), (x(1) * y(2) - y(1) * x(2)) / squared, 0.0};
  }
  const Eigen::Matrix3d R_vehicle_body = vehicle_from_body();
  const Eigen::Quaterniond q_world_vehicle = Eigen::AngleAxisd(yaw(0), Eigen::Vector3d::UnitZ()) *
                                             Eigen::AngleAxisd(pitch(0), Eigen::Vector3d::UnitY()) *
                                             Eigen::AngleAxisd(roll(0), Eigen::Vector3d::UnitX());
  k.T_world_body.q = (q_world_vehicle * Eigen::Quaterniond(R_vehicle_body)).normalized();
  const Eigen::Vector3d rates{roll(1) * w.ds, pitch(1) * w.ds, yaw(1) * w.ds};
  k.omega_b_radps = R_vehicle_body.transpose() * euler_rate(roll(0), pitch(0), rates);
  return k;
}

Result<std::unique_ptr<Trajectory>> make_trajectory(const SimulationOptions& options) {
  if (!options.path_file.empty()) return read_spline_trajectory(options.path_file);
  return std::unique_ptr<Trajectory>(std::make_unique<SineFlight>(options));
}

}  // namespace pled::sim
