#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "pled_vins/geometry/pose.hpp"

/// Straight lines in space and how a camera sees them.
namespace pled {

/// A line through the points x with n = x cross d, up to a common factor of both. |n| / |d| is its
/// distance from the origin. Not every pair is a line: n . d = 0.
struct PluckerLine {
  Eigen::Vector3d n = Eigen::Vector3d::UnitX();  ///< moment: normal of the plane with the origin
  Eigen::Vector3d d = Eigen::Vector3d::UnitZ();  ///< direction; 0 for a line at infinity
};

/// The same line with as many freedoms as it has: U in SO(3), whose columns are n / |n|, d / |d|
/// and their product, and W in SO(2), an angle with tan phi = |d| / |n|, one over the distance in
/// metres. Nothing is singular about the pair itself, but a step of the first order moves a line
/// through the origin only within a plane (and turns a line at infinity about one axis only): keep
/// the origin where no line passes, as in a camera that sees it.
struct OrthonormalLine {
  Eigen::Quaterniond U = Eigen::Quaterniond::Identity();
  double phi_rad = 0.0;
};

/// Step of an OrthonormalLine: three of U, on the right, then phi; rad.
using LineTangent = Eigen::Vector4d;

/// The line through two points, m. Equal points give no line: n = d = 0.
[[nodiscard]] PluckerLine line_through(const Eigen::Vector3d& a, const Eigen::Vector3d& b) noexcept;

/// The line in coordinates of frame a: n_a = R n_b + t cross R d_b, d_a = R d_b.
[[nodiscard]] PluckerLine operator*(const Pose& T_a_b, const PluckerLine& line_b) noexcept;

/// nullopt when the values are not finite, both are zero, or n and d are not perpendicular to 1e-6.
/// What rounding left of n . d is taken from the shorter of the two.
[[nodiscard]] std::optional<OrthonormalLine> to_orthonormal(const PluckerLine& line) noexcept;

/// n = cos(phi) u_1, d = sin(phi) u_2: |n|^2 + |d|^2 = 1.
[[nodiscard]] PluckerLine to_plucker(const OrthonormalLine& line) noexcept;

/// U Exp(delta_0..2), phi + delta_3.
[[nodiscard]] OrthonormalLine box_plus(const OrthonormalLine& line,
                                       const LineTangent& delta) noexcept;

/// The step from `from` to `to`. (n; d) and -(n; d) are one line but not one U: both must have
/// the same sign, as they have when steps lead from one to the other.
[[nodiscard]] LineTangent box_minus(const OrthonormalLine& to,
                                    const OrthonormalLine& from) noexcept;

/// d(n; d) of to_plucker() by the step.
[[nodiscard]] Eigen::Matrix<double, 6, 4> plucker_jacobian(const OrthonormalLine& line) noexcept;

/// The line's picture on the plane z = 1: l with l_1^2 + l_2^2 = 1, so that l . (x, y, 1) is the
/// signed distance of (x, y). On that plane l is n up to a factor.
/// nullopt when the line passes through the camera's centre (1 nm), its picture is at infinity, or
/// values are not finite. Lines behind the camera have pictures too: see point_seen_at().
[[nodiscard]] std::optional<Eigen::Vector3d> project(const PluckerLine& line_cam) noexcept;

/// The point of the line that is seen nearest to xy on the plane z = 1: where a segment with this
/// end in the picture ends in space. Camera frame, m.
/// nullopt when there is none in front of the camera, or the line is seen end on.
[[nodiscard]] std::optional<Eigen::Vector3d> point_seen_at(const PluckerLine& line_cam,
                                                           const Eigen::Vector2d& xy) noexcept;

/// The point of the line nearest to p; nullopt for a line at infinity.
[[nodiscard]] std::optional<Eigen::Vector3d> nearest_point(const PluckerLine& line,
                                                           const Eigen::Vector3d& p) noexcept;

/// Where two lines come nearest to each other.
struct NearestPoints {
  Eigen::Vector3d on_a;
  Eigen::Vector3d on_b;
};

/// nullopt for lines that are parallel to 1e-9 or at infinity.
[[nodiscard]] std::optional<NearestPoints> nearest_points(const PluckerLine& a,
                                                          const PluckerLine& b) noexcept;

}  // namespace pled
