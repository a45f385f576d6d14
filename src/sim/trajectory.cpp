#include "pled_vins/sim/trajectory.hpp"

#include <cmath>
#include <numbers>

#include "src/sim/random.hpp"

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

}  // namespace

RoomFlight::RoomFlight(std::uint64_t seed, StartKind start, double still_s, double scale,
                       double pace) noexcept
    : still_s_(still_s), starts_still_(start == StartKind::kStill) {
  // A wide path, a slower sway on it, and the shake of a hand: amplitude, rad/s.
  constexpr double kPosition[3][6] = {{1.05, 0.82, 0.24, 2.1, 0.008, 11.0},
                                      {1.25, 0.68, 0.22, 1.8, 0.009, 9.5},
                                      {0.28, 1.05, 0.07, 2.6, 0.007, 12.0}};
  constexpr double kAngles[3][6] = {{0.13, 0.75, 0.05, 1.9, 0.010, 10.5},
                                    {0.10, 0.95, 0.04, 2.2, 0.010, 9.0},
                                    {0.55, 0.55, 0.10, 1.4, 0.010, 8.0}};
  Random random = stream(seed, Stream::kFlight);
  const auto fill = [&random, pace](Channel& channel, const double(&row)[6], double size) {
    for (std::size_t k = 0; k < kTerms; ++k) {
      channel.terms[k] = {size * row[2 * k] * random.uniform(0.85, 1.15),
                          pace * row[2 * k + 1] * random.uniform(0.9, 1.1),
                          random.uniform(0.0, 2.0 * std::numbers::pi)};
    }
  };
  for (std::size_t i = 0; i < 3; ++i) fill(position_[i], kPosition[i], scale);
  for (std::size_t i = 0; i < 3; ++i) fill(angles_[i], kAngles[i], 1.0);
  position_[2].offset = 1.45 * scale;
}

Eigen::Vector3d RoomFlight::Channel::at(double s) const noexcept {
  Eigen::Vector3d sum{offset, 0.0, 0.0};
  for (const Sine& k : terms) {
    const double sine = std::sin(k.rate_radps * s + k.phase_rad);
    const double cosine = std::cos(k.rate_radps * s + k.phase_rad);
    sum += k.amplitude *
           Eigen::Vector3d{sine, k.rate_radps * cosine, -k.rate_radps * k.rate_radps * sine};
  }
  return sum;
}

RoomFlight::Warp RoomFlight::warp(double t_s) const noexcept {
  if (!starts_still_) return {t_s, 1.0, 0.0};
  const double x = (t_s - still_s_) / kRampS;
  if (!(x > 0.0)) return {0.0, 0.0, 0.0};
  if (x >= 1.0) return {(x - 0.5) * kRampS, 1.0, 0.0};
  // ds/dt = 10 x^3 - 15 x^4 + 6 x^5, flat to the second derivative at both ends.
  const double x3 = x * x * x;
  return {kRampS * x3 * x * (2.5 + x * (-3.0 + x)), x3 * (10.0 + x * (-15.0 + 6.0 * x)),
          30.0 * x * x * (1.0 - x) * (1.0 - x) / kRampS};
}

Kinematics RoomFlight::at(double t_s) const noexcept {
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
  const Eigen::Vector3d yaw = angles_[2].at(w.s);
  const Eigen::Matrix3d R_vehicle_body = vehicle_from_body();
  const Eigen::Quaterniond q_world_vehicle = Eigen::AngleAxisd(yaw(0), Eigen::Vector3d::UnitZ()) *
                                             Eigen::AngleAxisd(pitch(0), Eigen::Vector3d::UnitY()) *
                                             Eigen::AngleAxisd(roll(0), Eigen::Vector3d::UnitX());
  k.T_world_body.q = (q_world_vehicle * Eigen::Quaterniond(R_vehicle_body)).normalized();
  const Eigen::Vector3d rates{roll(1) * w.ds, pitch(1) * w.ds, yaw(1) * w.ds};
  k.omega_b_radps = R_vehicle_body.transpose() * euler_rate(roll(0), pitch(0), rates);
  return k;
}

}  // namespace pled::sim
