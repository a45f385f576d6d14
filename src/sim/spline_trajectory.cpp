#include "src/sim/spline_trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>

#include <Eigen/SparseCholesky>

namespace pled::sim {
namespace {

constexpr std::size_t kFewestSamples = 8;
constexpr double kHeadHeight_m = 1.45;
constexpr double kLongest_s = 3600.0;
constexpr double kSmoothing = 1e-3;  ///< of second differences of knots, against samples

/// Weights of the four knots around a place u in [0, 1) between two, and two derivatives by u.
struct Weights {
  Eigen::Vector4d value, first, second;
};
Weights weights(double u) {
  const double v = 1.0 - u;
  Weights w;
  w.value << v * v * v, 3 * u * u * u - 6 * u * u + 4, -3 * u * u * u + 3 * u * u + 3 * u + 1,
      u * u * u;
  w.first << -3 * v * v, 9 * u * u - 12 * u, -9 * u * u + 6 * u + 3, 3 * u * u;
  w.second << 6 * v, 18 * u - 12, -18 * u + 6, 6 * u;
  w.value /= 6.0;
  w.first /= 6.0;
  w.second /= 6.0;
  return w;
}

struct Place {
  std::size_t first;  ///< of the four knots
  double u;
};
/// A line of a TUM file; nothing when it is none.
std::optional<SplineTrajectory::Sample> read_sample(const std::string& line) {
  std::istringstream words(line);
  double v[8];
  for (double& number : v)
    if (!(words >> number) || !std::isfinite(number)) return std::nullopt;
  const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
  if (!(q.norm() > 0.5)) return std::nullopt;
  return SplineTrajectory::Sample{v[0], Pose{q.normalized(), Eigen::Vector3d(v[1], v[2], v[3])}};
}

Place place(double t_s, double step_s, std::size_t knots) {
  const double at = std::max(0.0, t_s / step_s);
  const std::size_t first = std::min(static_cast<std::size_t>(at), knots - 4);
  return {first, at - static_cast<double>(first)};
}

}  // namespace

SplineTrajectory::SplineTrajectory(const std::vector<Sample>& samples)
    : duration_s_(samples.back().t_s - samples.front().t_s) {
  const auto knots = static_cast<std::size_t>(duration_s_ / kKnotStep_s) + 4;
  const auto n = static_cast<Eigen::Index>(knots);
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::Matrix<double, Eigen::Dynamic, 7> rhs =
      Eigen::Matrix<double, Eigen::Dynamic, 7>::Zero(n, 7);
  Eigen::Vector4d last_q = samples.front().T_world_body.q.coeffs();
  for (const Sample& s : samples) {
    const Place at = place(s.t_s - samples.front().t_s, kKnotStep_s, knots);
    const Eigen::Vector4d w = weights(at.u).value;
    Eigen::Vector4d q = s.T_world_body.q.coeffs();
    if (q.dot(last_q) < 0) q = -q;  // the same turn, on the side of the one before
    last_q = q;
    Row row;
    row << s.T_world_body.p, q;
    for (Eigen::Index a = 0; a < 4; ++a) {
      const auto i = static_cast<Eigen::Index>(at.first) + a;
      rhs.row(i) += w(a) * row.transpose();
      for (Eigen::Index b = 0; b < 4; ++b)
        entries.emplace_back(i, static_cast<Eigen::Index>(at.first) + b, w(a) * w(b));
    }
  }
  constexpr double kSecond[3] = {1.0, -2.0, 1.0};
  for (Eigen::Index i = 0; i + 2 < n; ++i)
    for (Eigen::Index a = 0; a < 3; ++a)
      for (Eigen::Index b = 0; b < 3; ++b)
        entries.emplace_back(i + a, i + b, kSmoothing * kSecond[a] * kSecond[b]);
  Eigen::SparseMatrix<double> H(n, n);
  H.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(H);
  const Eigen::Matrix<double, Eigen::Dynamic, 7> solved = solver.solve(rhs);
  for (Eigen::Index i = 0; i < n; ++i) knots_.emplace_back(solved.row(i).transpose());
}

Kinematics SplineTrajectory::at(double t_s) const noexcept {
  const Place at = place(std::min(t_s, duration_s_), kKnotStep_s, knots_.size());
  const Weights w = weights(at.u);
  Row x = Row::Zero(), dx = Row::Zero(), ddx = Row::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    x += w.value(i) * knots_[at.first + k];
    dx += w.first(i) / kKnotStep_s * knots_[at.first + k];
    ddx += w.second(i) / (kKnotStep_s * kKnotStep_s) * knots_[at.first + k];
  }
  Kinematics out;
  out.T_world_body.p = x.head<3>();
  const Eigen::Vector4d s = x.tail<4>();
  const double length = s.norm();
  const Eigen::Vector4d unit = s / length;
  out.T_world_body.q = Eigen::Quaterniond(unit(3), unit(0), unit(1), unit(2));
  if (t_s < 0.0 || t_s > duration_s_) return out;
  out.v_wb_mps = dx.head<3>();
  out.a_wb_mps2 = ddx.head<3>();
  // d(s / |s|) is the part of ds across s, over |s|; omega = 2 Im(conj(q) dq).
  const Eigen::Vector4d ds = dx.tail<4>();
  const Eigen::Vector4d dq = (ds - unit * unit.dot(ds)) / length;
  const Eigen::Quaterniond rate(dq(3), dq(0), dq(1), dq(2));
  out.omega_b_radps = 2.0 * (out.T_world_body.q.conjugate() * rate).vec();
  return out;
}

Result<std::unique_ptr<Trajectory>> read_spline_trajectory(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) return ErrorCode::kNotFound;
  std::vector<SplineTrajectory::Sample> samples;
  std::int64_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.empty() || line[0] == '#') continue;
    const std::optional<SplineTrajectory::Sample> sample = read_sample(line);
    if (!sample || (!samples.empty() && !(sample->t_s > samples.back().t_s)))
      return Error{ErrorCode::kCorrupt, number};
    samples.push_back(*sample);
  }
  if (samples.size() < kFewestSamples) return ErrorCode::kUnsupported;
  if (samples.back().t_s - samples.front().t_s > kLongest_s) return ErrorCode::kTooLarge;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const SplineTrajectory::Sample& s : samples)
    middle += s.T_world_body.p / static_cast<double>(samples.size());
  for (SplineTrajectory::Sample& s : samples)
    s.T_world_body.p += Eigen::Vector3d(0.0, 0.0, kHeadHeight_m) - middle;
  return std::unique_ptr<Trajectory>(std::make_unique<SplineTrajectory>(samples));
}

}  // namespace pled::sim
