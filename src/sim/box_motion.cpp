#include "src/sim/box_motion.hpp"

#include <cmath>

namespace pled::sim {
namespace {

constexpr double kBobsPerWalk = 3.0;

/// Share of full speed, and of ramp times full speed, when a share x of the ramp is over.
double ramp_speed(double x) noexcept { return x * x * (3.0 - 2.0 * x); }
double ramp_way(double x) noexcept { return x * x * x * (1.0 - 0.5 * x); }

}  // namespace

Pose WalkPath::displaced(const Pose& rest, double t_s) const noexcept {
  if (!moves()) return rest;
  const double s = rate_radps * t_s + phase_rad;
  Pose pose = rest;
  pose.p += reach_m * std::sin(s);
  pose.p.z() += bob_m * std::sin(kBobsPerWalk * s);
  pose.q = pose.q * Eigen::AngleAxisd(turn_rad * std::sin(s), Eigen::Vector3d::UnitZ());
  return pose;
}

double WalkPath::speed_mps(double t_s, double reach) const noexcept {
  if (!moves()) return 0.0;
  const double s = rate_radps * t_s + phase_rad;
  const double along = reach_m.norm() * std::abs(std::cos(s));
  const double up = kBobsPerWalk * bob_m * std::abs(std::cos(kBobsPerWalk * s));
  const double turn = turn_rad * std::abs(std::cos(s)) * reach;
  return rate_radps * (along + up + turn);
}

DrivePath::Turn DrivePath::turn_at(double t_s) const noexcept {
  const double period_s = drive_s + stand_s;
  const double whole = std::floor((t_s + phase_s) / period_s);
  return {whole, t_s + phase_s - whole * period_s};
}

double DrivePath::driven_m(double t_s) const noexcept {
  if (!(drive_s > 0.0)) return speed_mps * t_s;
  const auto [whole, into_s] = turn_at(t_s);
  const double each_m = speed_mps * (drive_s - ramp_s);
  const double ramp_m = speed_mps * ramp_s;
  double way_m = each_m;
  if (into_s < ramp_s)
    way_m = ramp_m * ramp_way(into_s / ramp_s);
  else if (into_s < drive_s - ramp_s)
    way_m = 0.5 * ramp_m + speed_mps * (into_s - ramp_s);
  else if (into_s < drive_s)
    way_m = each_m - ramp_m * ramp_way((drive_s - into_s) / ramp_s);
  return whole * each_m + way_m;
}

double DrivePath::speed_at(double t_s) const noexcept {
  if (!(drive_s > 0.0)) return speed_mps;
  const double into_s = turn_at(t_s).into_s;
  if (into_s >= drive_s) return 0.0;
  const double from_rest_s = std::min(into_s, drive_s - into_s);
  return speed_mps * ramp_speed(std::min(1.0, from_rest_s / ramp_s));
}

Pose DrivePath::displaced(const Pose& rest, double t_s) const noexcept {
  if (!moves()) return rest;
  double way_m = offset_m + driven_m(t_s);
  if (wrap_m > 0.0) way_m -= wrap_m * std::floor(way_m / wrap_m + 0.5);
  Pose pose = rest;
  pose.p += way_m * direction;
  return pose;
}

}  // namespace pled::sim
